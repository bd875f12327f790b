// SPDX-License-Identifier: GPL-3.0-or-later
// Families of poses: pairs of bodies, how they lie near each other, and from where they meet. Bodies have about the
// radius 1 unless a family is of mixed sizes. Same family, seed and index, same case.
#pragma once
#include <functional>
#include <optional>
#include <string>

#include "tests/oracle/Judge.h"
#include "tests/oracle/Meshes.h"

namespace clod::oracle
{
// Two meshes with their centres of mass at the origin, vertices rounded to float, and where the origins of the frames
// that they were made in have gone.
struct BodyPair
{
	BodyPair(const TriangleMesh& meshA, const TriangleMesh& meshB);
	TriangleMesh a, b;
	Vec3 offsetA, offsetB;  // of the centres, in the frames of making
};

// Bodies apart, and the way on which A meets B.
struct Start
{
	Transform aFromB;  // frames of making
	Vec3 approach;     // unit, frame A
	double travel;     // they meet within it, mostly
	RelativeMotion course{};  // how A moves in its mechanism, of any size; frame of making; zero: no such course
};

struct Family
{
	std::string name, summary;
	std::function<std::vector<BodyPair>()> pairs;
	std::function<Start(Random&, std::size_t pair)> start;
	bool isDeep = false;  // poses of real overlap; else touching ones
};
const std::vector<Family>& families();

struct CaseChoice
{
	std::size_t pair;
	std::uint64_t seed;
};
CaseChoice chooseCase(const Family& family, std::size_t pairs, std::uint64_t seed, std::size_t index);
// A third touches (d = 0), a third has a gap, the others overlap slightly; a third each approaches, slides and moves
// anyhow, half of them spinning; with a course every other one follows it, more or less. Empty where the surfaces do
// not meet on the way. a and b are the surfaces in use.
std::optional<Case> makeCase(const Family& family, const BodyPair& pair, const CaseChoice& choice, const Solid& a,
							 const Solid& b);
}  // namespace clod::oracle
