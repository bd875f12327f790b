// SPDX-License-Identifier: GPL-3.0-or-later
// Families tried on a kind of subject, and what came of it.
#pragma once
#include "tests/oracle/Families.h"

namespace clod::oracle
{
using MakeSubject = std::function<std::unique_ptr<Subject>(const BodyPair& pair)>;

struct TrialRules
{
	JudgeRules judge;
	std::uint64_t seed = 1;
};

struct Trial
{
	Verdict verdict;
	Case which;
	Answer answer;
	std::size_t pair = 0;
	double radius = 1;
};

// Sums over a family's poses. Lengths are shares of the smaller radius.
struct FamilyResult
{
	std::string family;
	int poses = 0, unmade = 0;  // unmade: the bodies did not meet
	int mixed = 0;              // poses besides, not judged: contacts of several levels of one body
	int apart = 0, ghosts = 0;  // poses proved apart, and those of them where a constraint claims depth
	int overlapping = 0, unanswered = 0;
	double worstClaim = 0;
	double constraints = 0;  // a pose, on average
	std::array<Tally, std::size_t(Kind::count)> kinds;
	std::size_t worstPose = 0;
	double worst = 0;
	void add(const Trial& trial, const JudgeRules& rules, std::size_t index);
	const Tally& of(Kind kind) const { return kinds[std::size_t(kind)]; }
};

// One family's bodies on one kind of subject; subjects and solids are made once.
class FamilyTrials
{
public:
	FamilyTrials(const Family& family, const MakeSubject& make, const TrialRules& rules);
	// By its index: same family, rules and subject, same trial. Empty where the bodies do not meet.
	std::optional<Trial> run(std::size_t index);
	FamilyResult runAll(std::size_t poses);

private:
	Family m_family;
	TrialRules m_rules;
	std::vector<BodyPair> m_pairs;
	std::vector<std::unique_ptr<Subject>> m_subjects;
	SolidCache m_solids;
};

double quantile(std::vector<float>& values, double share);  // sorts; 0 where there are none
}  // namespace clod::oracle
