// SPDX-License-Identifier: Zlib
#include "clod/manifold/BodyBalance.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace clod
{
namespace
{
constexpr double kSettled = 1e-6;   // of the largest speed that contacts have to change
constexpr double kGoodEnough = 1e-3;  // of it: where friction has not settled any better
constexpr double kJammed = 1e-5;      // of it: what contacts that carry may lack; their impulses are a hundred times the body's
// Of the inverse mass, added to each contact's own: it makes contacts solvable that do the same, and is far below what
// tells those apart that are close together.
constexpr double kSoftness = 1e-7;
constexpr double kSliding = 0.999;  // of the most that friction can
constexpr double kSlidesFar = 2;    // times as fast as what friction can stop
constexpr int kRounds = 20;         // of normal impulses and friction by turns

using Six = std::array<double, 6>;

// Solves m x = b for a symmetric, positive definite m, of which the lower half is read (Cholesky, without roots).
void solveSix(std::array<Six, 6>& m, Six& b)
{
	for (std::size_t i = 0; i < 6; ++i)
	{
		for (std::size_t j = 0; j <= i; ++j)
		{
			for (std::size_t k = 0; k < j; ++k) m[i][j] -= m[i][k] * m[j][k] * m[k][k];
			if (j < i) m[i][j] /= m[j][j];
		}
		for (std::size_t k = 0; k < i; ++k) b[i] -= m[i][k] * b[k];
	}
	for (std::size_t i = 6; i-- > 0;)
	{
		b[i] /= m[i][i];
		for (std::size_t k = i + 1; k < 6; ++k) b[i] -= m[k][i] * b[k];
	}
}
}  // namespace

void BodyBalance::start(const PairBody& body)
{
	m_body = body;
	m_rows.clear();
}

Vec3 BodyBalance::velocityAt(const Row& row) const
{
	return m_body.linear + cross(m_body.angular, row.arm) - row.contact.otherVelocity;
}

// The speed by which the body would have to leave faster.
double BodyBalance::lacking(const Row& row) const
{
	return row.contact.target - dot(row.contact.normal, velocityAt(row));
}

double BodyBalance::effectiveMass(const Vec3& direction, const Vec3& turn) const
{
	return 1 / (m_body.inverseMass * lengthSquared(direction) + dot(turn, m_body.inverseInertia * turn));
}

void BodyBalance::push(const Row& row, const Vec3& impulse)
{
	m_body.linear += m_body.inverseMass * impulse;
	m_body.angular += m_body.inverseInertia * cross(row.arm, impulse);
}

// False if the body cannot turn about some axis: it is held by more than contacts.
bool BodyBalance::prepare()
{
	const Mat3& inverse = m_body.inverseInertia;
	const Vec3 x = cross(inverse.row[1], inverse.row[2]);
	const double determinant = dot(inverse.row[0], x);
	if (!(m_body.inverseMass > 0 && determinant > 0)) return false;
	const double share = m_body.inverseMass / determinant;
	const Vec3 y = cross(inverse.row[2], inverse.row[0]), z = cross(inverse.row[0], inverse.row[1]);
	m_inertiaShare = {{share * x, share * y, share * z}};
	m_least = 0;
	for (Row& row : m_rows)
	{
		row.arm = row.contact.place - m_body.center;
		row.turn = cross(row.arm, row.contact.normal);
		m_least = std::max(m_least, kSettled * std::abs(lacking(row)));
	}
	for (const Row& row : m_rows)
		if (row.contact.impulse != 0 || row.contact.rub != Vec3{})
			push(row, row.contact.impulse * row.contact.normal + row.contact.rub);
	return true;
}

// By how much the impulses that carry have to change to give their contacts the speed asked for.
void BodyBalance::findSteps()
{
	std::array<Six, 6> m{};
	for (std::size_t i = 0; i < 3; ++i)
	{
		const Vec3& turning = m_inertiaShare.row[i];
		m[i][i] = kSoftness;
		m[3 + i] = {0, 0, 0, kSoftness * turning.x, kSoftness * turning.y, kSoftness * turning.z};
	}
	Six change{};
	for (Row& row : m_rows)
	{
		if (!row.carries()) continue;
		row.step = lacking(row);
		const Vec3 &normal = row.contact.normal, &turn = row.turn;
		const Six way = {normal.x, normal.y, normal.z, turn.x, turn.y, turn.z};
		for (std::size_t i = 0; i < 6; ++i)
		{
			change[i] += way[i] * row.step;
			for (std::size_t j = 0; j <= i; ++j) m[i][j] += way[i] * way[j];
		}
	}
	solveSix(m, change);  // how the body's motion then changes
	const Vec3 linear = {change[0], change[1], change[2]}, angular = {change[3], change[4], change[5]};
	for (Row& row : m_rows)
		if (row.carries())
			row.step = (row.step - dot(row.contact.normal, linear) - dot(row.turn, angular)) /
					   (kSoftness * m_body.inverseMass);
}

// Takes the steps as far as none pulls. Returns the contact that would, which carries no longer.
BodyBalance::Row* BodyBalance::takeSteps()
{
	double share = 1;
	Row* first = nullptr;
	for (Row& row : m_rows)
	{
		if (!row.carries() || row.contact.impulse + share * row.step >= 0) continue;
		share = -row.contact.impulse / row.step;
		first = &row;
	}
	for (Row& row : m_rows)
	{
		if (!row.carries()) continue;
		const double old = row.contact.impulse;
		row.contact.impulse = &row == first ? 0 : std::max(0.0, old + share * row.step);
		push(row, (row.contact.impulse - old) * row.contact.normal);
	}
	return first;
}

// Lets the contact carry that lacks most. Null where none does.
BodyBalance::Row* BodyBalance::addLowest()
{
	Row* lowest = nullptr;
	double most = m_least;
	for (Row& row : m_rows)
	{
		if (row.carries() || lacking(row) <= most) continue;
		most = lacking(row);
		lowest = &row;
	}
	if (!lowest) return nullptr;
	lowest->contact.impulse = most * effectiveMass(lowest->contact.normal, lowest->turn);
	push(*lowest, lowest->contact.impulse * lowest->contact.normal);
	return lowest;
}

// An active set: each round makes the whole nearer to balance, so that no set of contacts comes twice. False if there are
// more rounds than it should take.
bool BodyBalance::balanceNormals()
{
	for (std::size_t round = 0; round < 3 * m_rows.size(); ++round)
	{
		findSteps();
		if (!takeSteps() && !addLowest()) return true;
	}
	return false;
}

// Friction against the sliding, contact by contact. Returns the largest speed that it changes.
double BodyBalance::rub()
{
	double change = 0;
	for (Row& row : m_rows)
	{
		if (!(row.contact.friction > 0) || (!row.carries() && row.contact.rub == Vec3{})) continue;
		const Vec3 speed = velocityAt(row), &normal = row.contact.normal;
		const Vec3 sliding = speed - dot(speed, normal) * normal, along = normalized(sliding);
		if (along == Vec3{}) continue;
		const double mass = effectiveMass(along, cross(row.arm, along)), most = row.contact.friction * row.contact.impulse;
		Vec3 next = row.contact.rub - mass * sliding;
		const double size = length(next);
		if (size > most) next = (most / size) * next;
		change = std::max(change, length(next - row.contact.rub) / mass);
		push(row, next - row.contact.rub);
		row.contact.rub = next;
	}
	return change;
}

// By what the contact that lacks most would have to bear if it lay beneath the middle.
bool BodyBalance::slidesFast() const
{
	const auto speedAt = [&](const Contact& contact) { return m_body.velocityAt(contact.place) - contact.otherVelocity; };
	double gained = 0;  // a speed: the load times the inverse mass
	for (const Row& row : m_rows)
		gained = std::max(gained, row.contact.target - dot(row.contact.normal, speedAt(row.contact)));
	const Mat3& turns = m_body.inverseInertia;
	const double turning = (turns.row[0].x + turns.row[1].y + turns.row[2].z) / m_body.inverseMass;
	const auto isFast = [&](const Row& row)
	{
		const Contact& contact = row.contact;
		const Vec3 speed = speedAt(contact), sliding = speed - dot(speed, contact.normal) * contact.normal;
		const double most =
			kSlidesFar * contact.friction * gained * (1 + turning * lengthSquared(contact.place - m_body.center));
		return most > 0 && lengthSquared(sliding) > most * most;
	};
	return std::all_of(m_rows.begin(), m_rows.end(), isFast);
}

bool BodyBalance::solve()
{
	if (!prepare()) return false;
	double change = 0;
	// Contacts that ask for what they cannot have together, as those of a jammed nut do, lack speed under any impulses, and
	// get such as are beyond all measure.
	const auto isJammed = [&](const Row& row) { return row.carries() && lacking(row) > kJammed / kSettled * m_least; };
	for (int round = 0; round < kRounds; ++round)
	{
		if (!balanceNormals() || std::any_of(m_rows.begin(), m_rows.end(), isJammed)) return false;
		change = rub();
		if (change <= m_least) return true;
	}
	return change <= kGoodEnough / kSettled * m_least;
}

bool BodyBalance::slides() const
{
	const auto rubs = [](const Row& row)
	{ return row.carries() && length(row.contact.rub) >= kSliding * row.contact.friction * row.contact.impulse; };
	return std::any_of(m_rows.begin(), m_rows.end(), [&](const Row& row) { return row.contact.friction > 0 && rubs(row); });
}
}  // namespace clod
