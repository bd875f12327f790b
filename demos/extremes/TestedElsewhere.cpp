// SPDX-License-Identifier: Zlib
// Rows that are no run with a number, and the tests that hold them.
#include "demos/extremes/Row.h"

namespace clod::demo
{
const std::vector<TestedElsewhere>& testedElsewhere()
{
	static const std::vector<TestedElsewhere> all = {
		{"E15", "sleep and wake with a cached front",
		 "LifecycleTest: ARestingPairSleepsAndWakes; CacheTest: CachedEqualsFreshBitForBit"},
		{"E18", "s0 = 0 on random poses", "QueryTest: ExactEqualsBruteForceOverAllLeafPairs"},
		{"E19", "s0 negative or not a number", "ContactMetricTest: RefusesWhatCannotBeUsedByName"},
		{"E21", "budgets from nothing to full",
		 "BudgetTest: IsExceededOnlyByTheCoarsestAnswers, TheCoarsestAnswersCarryBodiesToo, "
		 "AFullOneGivesTheTrajectoryOfNone"},
		{"E22", "an eye in, behind or inside the contact",
		 "MetricTest: AnEyeAtBehindOrInsideTheContactSeesItFromTheNearPlane, RefusesWhatCannotBeUsedByName"},
		{"E23", "speeds of zero and not a number",
		 "MetricTest: AtRestTheVelocityMetricIsItsFloor; MetricTest: WhatMovesIsCoarserAndRestCostsTheFloor"},
		{"E24", "a coarsening without end", "BudgetTest: WithoutEndIsTheCoarsestValidAnswer"},
		{"E25", "a pose that is not finite", "LifecycleTest: WhatIsNotFiniteIsSaidAndHasNoContacts"},
		{"E26", "memory of a pair", "AllocationTest: OfAPairIsWhatItsContactsTake"},
		{"E27", "float and double Bullet", "clod-bench-float64 extremes"},
		{"E28", "compilers and instruction sets", "TrajectoryTest: IsTheSameWithoutAvx2; scripts/same-bits"},
		{"E29", "bodies the other way round",
		 "LifecycleTest: TwoRunsGiveTheSameBitsInEitherOrderOfCreation; ContactTest: "
		 "SwappedBodiesNegateTheNormalAndKeepTheDistance"},
		{"E30", "bodies that come and go, two worlds, threads",
		 "LifecycleTest: RemovalLeavesNoManifold; BudgetTest: BodiesComeAndGo, WorldsMayShareAContext; ThreadsTest: "
		 "GiveTheSameTrajectoryHoweverMany"},
		{"E31", "stretched, mirrored and zero scales",
		 "ScaleTest: StretchedBodiesRestAtTheirHeight, ARefusedScaleIsToldOf"},
		{"E32", "more than 90 degrees a step", "CacheTest: CachedEqualsFreshBitForBit (its poses leap)"},
		{"C4", "a loaded pin pressed into its hole", "PressTest: TenTimesItsWeightSinksNoDeeperThanAHundredth"},
		{"C8", "rebounds", "clod-bench extremes --only A7"},
		{"C10", "levels that switch", "clod-bench extremes --only E16"},
		{"C7", "what flies past is not deflected", "ContactSceneTest: WhatJustMissesIsNotDeflected"},
	};
	return all;
}
}  // namespace clod::demo
