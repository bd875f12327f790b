// SPDX-License-Identifier: Zlib
// The stability matrix as data. A row shows one extreme or one case with a closed form; it is run for each of its cases
// (sizes, speeds, resolutions), at each of its rates, by each collider, and gives numbers that a bound judges.
#pragma once
#include <functional>
#include <string>
#include <vector>

namespace clod::demo
{
class Workshop;

// What bodies collide as.
enum class Collider
{
	primitive,  // Bullet's own solid: box, sphere, cylinder
	mesh,       // Bullet's best shape of the same mesh: hull, static tree of triangles, or GImpact
	exact,      // ours, the input surface
	standard,   // ours, certified to 0.5 % of the radius, the default
	coarse      // ours, the paper's s0 = 3.5 % of the radius
};
constexpr int kColliders = 5;
constexpr Collider kEveryCollider[kColliders] = {Collider::primitive, Collider::mesh, Collider::exact, Collider::standard,
												   Collider::coarse};
inline bool isOurs(Collider collider)
{
	return collider >= Collider::exact;
}
const char* name(Collider collider);

// One run of a row.
struct Setting
{
	Collider collider = Collider::exact;
	double rate = 240;     // steps a second
	double parameter = 0;  // of the case
	bool isQuick = false;  // long ones may be cut short
	double dt() const { return 1 / rate; }
};

// A number of a run, what it should be, and how far it is off: the smaller the better.
struct Reading
{
	double value = 0, expected = 0, error = 0;
};
Reading relativeTo(double expected, double value);
Reading differenceFrom(double expected, double value);
// Of what should be as small as can be.
Reading amount(double value);

// The error may be at most `most`, or what Bullet's best shape of the same mesh has in the same run: so many times its
// error and so much more.
struct Bound
{
	double most = 0;
	double timesMesh = 0;  // 0: what Bullet does is no excuse
	double beyondMesh = 0;
};

struct Quantity
{
	std::string name, unit;  // of the error
	Bound bound;
};

// Where a row falls outside its bound and why, so that nobody finds out by himself.
struct Limit
{
	std::string beyond;  // what happens there
	std::function<bool(const Setting&)> covers;
	std::string quantity;  // empty: all
};

// Of which runs a limit is.
inline bool anyRun(const Setting&)
{
	return true;
}
inline bool largeSteps(const Setting& setting)
{
	return setting.rate <= 60;
}
inline bool coarseLevels(const Setting& setting)
{
	return setting.collider == Collider::coarse;
}

struct Case
{
	double parameter = 0;
	std::string label;
};

struct Row
{
	std::string id;      // "E4", "A13", ...: of the list that the row is from
	std::string shows;   // what is done
	std::string source;  // of the bound: the formula, or against whom
	std::string axis;    // of the validity map, whose places are the cases (of "step": the rates); empty: none
	std::vector<Case> cases;
	std::vector<double> rates;
	std::vector<Quantity> quantities;
	std::function<std::vector<Reading>(Workshop&, const Setting&)> run;  // one reading a quantity; none: not for it
	std::vector<Limit> limits = {};
	bool isSlow = false;  // left out by --quick, which runs the first case and rate of the others
};

// What is no number of a run, and the test that holds it.
struct TestedElsewhere
{
	const char* id;
	const char* shows;
	const char* test;  // program: case
};

std::vector<Row> engineRows();    // E: extremes of the engine
std::vector<Row> levelRows();     // E: levels that switch, thresholds at their ends
std::vector<Row> analyticRows();  // A: closed forms
std::vector<Row> roundRows();     // A: those of what rolls
std::vector<Row> contactRows();   // C: faults that contact points had
std::vector<Row> jointRows();     // J: bodies joined by Bullet's constraints
std::vector<Row> allRows();       // by letter and number
const std::vector<TestedElsewhere>& testedElsewhere();
}  // namespace clod::demo
