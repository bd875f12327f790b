// SPDX-License-Identifier: Zlib
// What contacts give one body that lies, rolls or rocks on another, found exactly: impulses that leave every contact at
// least the speed asked for, none of which pulls, with Coulomb's friction.
//
// A solver that goes from row to row hardly tells two contacts apart that are close together, beside the body's radius
// of gyration: of a ring that rolls on a peg each round moves a fivehundredth of the load from one to the other. The
// load then lags behind the motion by many steps, pushes where the body leaves, and small swings never end.
#pragma once
#include <vector>

#include "clod/Export.h"
#include "clod/manifold/ContactPoints.h"

namespace clod
{
class CLOD_API BodyBalance
{
public:
	struct Contact
	{
		Vec3 place, normal;     // away from the other body
		Vec3 otherVelocity;     // there, which the contacts do not change
		double target = 0;      // least speed along the normal, relative to it
		double friction = 0;    // Coulomb's coefficient
		double impulse = 0;     // along the normal: a guess, then the answer; where contacts do the same, the least change
		Vec3 rub = {};          // friction's impulse, the same
	};
	// The body as forces alone would move it. In any frame and unit.
	void start(const PairBody& body);
	void add(const Contact& contact) { m_rows.push_back({contact, {}, {}, 0}); }
	// Before it is solved: do all of them slide so fast that friction can stop none?
	bool slidesFast() const;
	// False if the body cannot turn freely, where friction does not settle, or where it is jammed: then the answer is none.
	bool solve();
	// Does one that carries rub as much as it can?
	bool slides() const;
	const Contact& contact(std::size_t i) const { return m_rows[i].contact; }
	const PairBody& body() const { return m_body; }  // as they move it

private:
	struct Row
	{
		Contact contact;
		Vec3 arm, turn;  // from the middle, and its cross product with the normal
		double step;     // of the impulse
		bool carries() const { return contact.impulse > 0; }
	};
	Vec3 velocityAt(const Row& row) const;
	double lacking(const Row& row) const;
	double effectiveMass(const Vec3& direction, const Vec3& turn) const;
	void push(const Row& row, const Vec3& impulse);
	bool prepare();
	void findSteps();
	Row* takeSteps();
	Row* addLowest();
	bool balanceNormals();
	double rub();
	PairBody m_body;
	Mat3 m_inertiaShare;  // inertia over mass
	double m_least = 0;   // the least speed that counts
	std::vector<Row> m_rows;
};
}  // namespace clod
