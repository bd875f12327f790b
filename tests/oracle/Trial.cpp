// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/oracle/Trial.h"

#include <algorithm>
#include <cmath>

namespace clod::oracle
{
namespace
{
constexpr int kLevelRounds = 3;  // a pose is made for the surfaces that were in use in the round before

// The last of a body's surfaces is its coarsest.
std::uint32_t coarser(std::uint32_t surface, const std::vector<TriangleMesh>& surfaces)
{
	return std::min<std::uint32_t>(surface + 1, std::uint32_t(surfaces.size()) - 1);
}
}

void FamilyResult::add(const Trial& trial, const JudgeRules& rules, std::size_t index)
{
	const Verdict& verdict = trial.verdict;
	if (trial.answer.isMixed)
	{
		++mixed;
		return;
	}
	++poses;
	constraints += (double(verdict.constraints) - constraints) / poses;
	if (verdict.isApart)
	{
		++apart;
		ghosts += verdict.claim > rules.claim;
		worstClaim = std::max(worstClaim, verdict.claim);
	}
	else if (verdict.startDepth > rules.claim)
	{
		++overlapping;
		unanswered += !verdict.isAnswered;
	}
	for (std::size_t k = 0; k < kinds.size(); ++k) kinds[k].add(verdict.kinds[k]);
	if (verdict.worst() > worst)
	{
		worst = verdict.worst();
		worstPose = index;
	}
}

FamilyTrials::FamilyTrials(const Family& family, const MakeSubject& make, const TrialRules& rules)
	: m_family(family), m_rules(rules), m_pairs(family.pairs())
{
	for (const BodyPair& pair : m_pairs) m_subjects.push_back(make(pair));
}

std::optional<Trial> FamilyTrials::run(std::size_t index)
{
	const CaseChoice choice = chooseCase(m_family, m_pairs.size(), m_rules.seed, index);
	Subject& subject = *m_subjects[choice.pair];
	Trial trial;
	trial.pair = choice.pair;
	std::uint32_t surfaceA = 0, surfaceB = 0;
	for (int round = 0; round < kLevelRounds; ++round)
	{
		const std::optional<Case> made =
			makeCase(m_family, m_pairs[choice.pair], choice, m_solids.of(subject.surfacesA()[surfaceA]),
					 m_solids.of(subject.surfacesB()[surfaceB]));
		if (!made) return {};
		trial.which = *made;
		trial.answer = subject.answer(made->aFromB, made->motion);
		if (!trial.answer.knowsSurfaces)
		{
			// Those in use are coarser, and apart where these touch: they are brought together instead.
			const std::uint32_t nextA = coarser(surfaceA, subject.surfacesA()), nextB = coarser(surfaceB, subject.surfacesB());
			if (nextA == surfaceA && nextB == surfaceB)
			{
				if (surfaceA == 0 && surfaceB == 0) break;
				return {};
			}
			surfaceA = nextA;
			surfaceB = nextB;
			--round;
			continue;
		}
		if (trial.answer.surfaceA == surfaceA && trial.answer.surfaceB == surfaceB) break;
		surfaceA = trial.answer.surfaceA;
		surfaceB = trial.answer.surfaceB;
	}
	trial.answer.surfaceA = surfaceA;
	trial.answer.surfaceB = surfaceB;
	Random random(choice.seed + 1);
	const Solid &a = m_solids.of(subject.surfacesA()[surfaceA]), &b = m_solids.of(subject.surfacesB()[surfaceB]);
	trial.radius = std::min(a.radius(), b.radius());
	trial.verdict = judge(a, b, trial.which, trial.answer, subject.skin(), m_rules.judge, random);
	return trial;
}

FamilyResult FamilyTrials::runAll(std::size_t poses)
{
	FamilyResult result;
	result.family = m_family.name;
	for (std::size_t i = 0; i < poses; ++i)
	{
		const std::optional<Trial> trial = run(i);
		if (trial)
			result.add(*trial, m_rules.judge, i);
		else
			++result.unmade;
	}
	return result;
}

double quantile(std::vector<float>& values, double share)
{
	if (values.empty()) return 0;
	std::sort(values.begin(), values.end());
	const std::size_t index = std::size_t(std::ceil(share * double(values.size())));
	return double(values[std::min(values.size(), std::max<std::size_t>(index, 1)) - 1]);
}
}  // namespace clod::oracle
