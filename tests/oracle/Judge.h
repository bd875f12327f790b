// SPDX-License-Identifier: GPL-3.0-or-later
// The motion oracle: what motions do these contacts allow? Of a pose and a predicted motion the subject gives
// constraints; motions around the predicted one are tried on the meshes themselves, over their whole paths.
//   Sound: a motion that all constraints admit does not get deeper than the skin.
//   Free: a motion that keeps the meshes apart is not changed. The change is the least in the norm of kinetic energy.
// Constraints are linear: to both |w|^2 r dt^2 / 2 is granted, what turning adds to a path.
// Bodies that overlap slightly at the pose are led out of it: on the way they may be as deep as they are there.
#pragma once
#include <map>
#include <memory>

#include "tests/oracle/Motions.h"
#include "tests/oracle/Overlap.h"

namespace clod::oracle
{
// Shares of the smaller body's radius unless named otherwise.
struct JudgeRules
{
	int samples = 48;              // motions in each cone; half as many small ones
	double untouched = 1e-5;       // depth up to which bodies count as apart during a motion
	double untouchedShare = 0.02;  // and of the motion's size
	double claim = 1e-4;           // depth that a constraint must not claim of bodies apart
	double deep = 0.01;            // depth at the pose from which on only an answer is asked for
	double change = 0.1;           // of a free motion, by which it may be changed
	double pathStep = 0.004;       // between two looks at a path
	double small = 1e-3;           // size of the small motions where the gap is zero
};

// Motions of one kind, over all poses.
struct Tally
{
	int motions = 0, free = 0, admitted = 0;
	int changed = 0, pierced = 0;  // free motions changed by more than allowed; admitted ones deeper than allowed
	int bestHalfSpace = 0;  // of the cones: what the best single half space would get wrong, pose by pose
	std::vector<float> changes;    // of free motions, shares of themselves
	std::vector<float> depths;     // of admitted motions beyond the second order, shares of the radius
	int faults() const { return changed + pierced; }
	void add(const Tally& other);
};

enum class Kind
{
	near5,
	near30,
	small,
	solved,  // what the pair's own solve makes of those within 5 degrees: free is not asked
	count
};

struct Verdict
{
	bool isApart = false, isAnswered = true;
	double startDepth = 0;  // share of the radius
	double claim = 0;       // deepest that a constraint claims of bodies apart, share of the radius
	std::array<Tally, std::size_t(Kind::count)> kinds;
	std::size_t constraints = 0;
	double worst() const;  // orders the poses: the larger, the worse
	double worstOf[2] = {0, 0};  // change of a free motion, depth of an admitted one (share of the radius)
};

// Solids of the subjects' surfaces, made once.
class SolidCache
{
public:
	const Solid& of(const TriangleMesh& mesh);

private:
	std::map<const TriangleMesh*, std::unique_ptr<Solid>> m_solids;
};

struct Case
{
	Transform aFromB;
	RelativeMotion motion;  // predicted
	double gap = 0;         // size of the small motions, a length; 0: JudgeRules::small
};

// `answer` is the subject's for this case; a and b the surfaces it is of.
Verdict judge(const Solid& a, const Solid& b, const Case& which, const Answer& answer, double skin,
			  const JudgeRules& rules, Random& random);
}  // namespace clod::oracle
