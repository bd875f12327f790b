// SPDX-License-Identifier: Zlib
#include "clod/bullet/Context.h"

#include <BulletCollision/CollisionDispatch/btCollisionCreateFunc.h>
#include <xxhash.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <limits>

#include "clod/bullet/PairState.h"
#include "clod/bullet/btClodDispatcher.h"

int CLOD_ABI_SYMBOL = 1;  // Abi.h

namespace clod
{
namespace
{
constexpr int kAsked = 1000;  // before this many boxes a program may still be setting up its world
std::atomic<int> g_unregistered{0};  // boxes asked for; negative once a dispatcher is registered
}  // namespace

void warnIfUnregistered()
{
	if (g_unregistered.load(std::memory_order_relaxed) < 0) return;
	if (g_unregistered.fetch_add(1, std::memory_order_relaxed) != kAsked) return;
	std::fprintf(stderr, "clod: bodies of btClodShape are in a world, but no dispatcher was registered: "
						 "they touch nothing. Call btClodCollisionAlgorithm::registerAlgorithm or clod::setUpWorld\n");
}

void Context::noteRegistration()
{
	g_unregistered.store(std::numeric_limits<int>::min(), std::memory_order_relaxed);
}

Context::Context() : warn([](const std::string& message) { std::fprintf(stderr, "clod: %s\n", message.c_str()); }) {}
Context::~Context()
{
	if (!m_pairs.empty() && warn)
		warn("a Context is destroyed before the pairs of its world, which would go on to use it: it has to outlive the world");
	for (PairState* pair : m_pairs) pair->loseContext();
}

void Context::add(PairState* pair)
{
	const std::lock_guard<std::mutex> lock(m_mutex);
	m_pairs.push_back(pair);
}

const std::vector<PairState*>& Context::enlist(const btCollisionObject& body, PairState* pair)
{
	const std::lock_guard<std::mutex> lock(m_mutex);
	std::vector<PairState*>& pairs = m_ofBody[&body];
	pairs.push_back(pair);
	return pairs;
}

void Context::strike(const btCollisionObject& body, PairState* pair)
{
	const std::lock_guard<std::mutex> lock(m_mutex);
	const auto listed = m_ofBody.find(&body);
	std::vector<PairState*>& pairs = listed->second;
	pairs.erase(std::find(pairs.begin(), pairs.end(), pair));
	if (pairs.empty()) m_ofBody.erase(listed);
}

void Context::remove(PairState* pair)
{
	const std::lock_guard<std::mutex> lock(m_mutex);
	m_pairs.erase(std::find(m_pairs.begin(), m_pairs.end(), pair));
}

// Of the steps that a pair made now takes part in, if any. Only our dispatcher tells steps from a character's questions.
StepBudget* Context::budgetOf(btDispatcher& dispatcher, bool isOfGhost)
{
	if (auto* ours = dynamic_cast<btClodDispatcher*>(&dispatcher)) return ours->stepBudget();
	return isOfGhost ? nullptr : &m_stepBudget;
}

void Context::expect(StepBudget& stepBudget)
{
	if (!stepBudget.isLimited()) return;
	const std::lock_guard<std::mutex> lock(m_mutex);
	for (PairState* pair : m_pairs) pair->expect(stepBudget);
}

double Context::enterStep(StepBudget& stepBudget, std::uint64_t& lastStep)
{
	const Budget usable = usableBudget();
	if (&stepBudget != &m_stepBudget || !(usable.isLimited() || m_stepBudget.isLimited()))
	{
		lastStep = stepBudget.step();
		return stepBudget.coarsening();
	}
	const std::lock_guard<std::mutex> lock(m_mutex);
	if (lastStep == m_stepBudget.step() || !m_stepBudget.isOf(usable))
	{
		m_stepBudget.end();
		m_stepBudget.begin(usable);
		for (PairState* pair : m_pairs) pair->expect(m_stepBudget);
	}
	lastStep = m_stepBudget.step();
	return m_stepBudget.coarsening();
}

void Context::say(unsigned cause, const std::string& message)
{
	const std::lock_guard<std::recursive_mutex> lock(m_saying);
	const int said = ++m_said[cause];
	const auto handler = warn;  // one that replaces itself goes on to its end
	if (!handler || said > kMostMessages) return;
	handler(said < kMostMessages ? message : message + " (further pairs of which the same holds are not told of)");
}

// By index, and not locked during a visit: pairs may come, as those of a contactTest do, and go.
PairState* Context::pairAt(std::size_t index) const
{
	const std::lock_guard<std::mutex> lock(m_mutex);
	return index < m_pairs.size() ? m_pairs[index] : nullptr;
}

void Context::pairsOf(const btDispatcher& dispatcher, std::vector<PairState*>& pairs) const
{
	const std::lock_guard<std::mutex> lock(m_mutex);
	pairs.clear();
	for (PairState* pair : m_pairs)
		if (pair->isOf(dispatcher)) pairs.push_back(pair);
}

std::shared_ptr<const SavedContacts> Context::saveContacts(const btDispatcher& dispatcher) const
{
	auto contacts = std::make_shared<SavedContacts>();
	contacts->order = sharedIn(dispatcher).order.step();
	std::vector<PairState*> pairs;
	pairsOf(dispatcher, pairs);
	for (const PairState* pair : pairs)
		if (std::optional<PairState::Saved> saved = pair->save()) contacts->pairs.push_back(std::move(*saved));
	return contacts;
}

std::size_t Context::restoreContacts(const btDispatcher& dispatcher, const SavedContacts& saved)
{
	sharedIn(dispatcher).order.goOnFrom(saved.order);
	std::vector<const PairState::Saved*> left;
	for (const PairState::Saved& each : saved.pairs) left.push_back(&each);
	std::vector<PairState*> pairs;
	pairsOf(dispatcher, pairs);
	for (PairState* pair : pairs)
	{
		const auto mine = std::find_if(left.begin(), left.end(), [&](const auto* each) { return pair->isOf(*each); });
		pair->restore(mine != left.end() ? **mine : PairState::Saved());
		if (mine != left.end()) left.erase(mine);
	}
	return std::size_t(
		std::count_if(left.begin(), left.end(), [](const auto* each) { return each->manifolds.areAny(); }));
}

std::uint64_t hashOf(const SavedContacts& contacts)
{
	std::uint64_t sum = 0;
	std::vector<double> numbers;
	for (const PairState::Saved& pair : contacts.pairs)
	{
		numbers.clear();
		pair.addTo(numbers);
		if (!numbers.empty()) sum += XXH3_64bits(numbers.data(), numbers.size() * sizeof(double));
	}
	return sum;
}

Context::Shared& Context::sharedIn(const btDispatcher& dispatcher) const
{
	const std::lock_guard<std::mutex> lock(m_mutex);
	return m_shared[&dispatcher];
}

void Context::forEachPair(const std::function<void(const PairReport&)>& visit) const
{
	std::size_t index = 0;
	while (const PairState* pair = pairAt(index++)) visit(pair->lastReport());
}

StepReport Context::lastStep() const
{
	StepReport sum;
	forEachPair([&sum](const PairReport& pair) { addTo(sum, pair); });
	return sum;
}
}  // namespace clod
