// SPDX-License-Identifier: GPL-3.0-or-later
// What contacts give one body: none pulls, none lacks speed, and what needs no push gets none; friction stays within its
// cone, and against the sliding.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "clod/manifold/BodyBalance.h"

namespace clod
{
namespace
{
constexpr double kExact = 1e-5;  // of speeds of about 1
constexpr double kRubbed = 0.005;  // where friction and normal impulses are found by turns

// Of mass 1 / 2 that falls at 1 and turns, its moments of inertia as different as a ring's.
PairBody falling(const Vec3& turning)
{
	PairBody body;
	body.inverseMass = 2;
	body.inverseInertia = {{{3, 0.5, 0}, {0.5, 4, 0}, {0, 0, 2}}};
	body.center = {0.1, 0.2, 0.3};
	body.linear = {0.2, -1, 0.1};
	body.angular = turning;
	return body;
}

class Balance : public testing::Test
{
protected:
	double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(m_random); }
	Vec3 uniform() { return {uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)}; }
	// Below the body, leaning by up to some 35 degrees.
	BodyBalance::Contact contact(double friction = 0)
	{
		const Vec3 lean = {uniform(-0.5, 0.5), 1, uniform(-0.5, 0.5)};
		const Vec3 place = {uniform(-1, 1), uniform(-1, -0.8), uniform(-1, 1)};
		return {place, normalized(lean), 0.1 * uniform(), uniform(-0.1, 0.1), friction};
	}
	Vec3 speedAt(const BodyBalance::Contact& c) const
	{
		const PairBody& body = m_balance.body();
		return body.linear + cross(body.angular, c.place - body.center) - c.otherVelocity;
	}
	// Solves, and expects the conditions of an answer if there is one.
	bool expectBalance(const PairBody& body, const std::vector<BodyBalance::Contact>& contacts, double tolerance = kExact)
	{
		m_balance.start(body);
		for (const auto& c : contacts) m_balance.add(c);
		if (!m_balance.solve()) return false;
		Vec3 linear = body.linear, angular = body.angular;
		for (std::size_t i = 0; i < contacts.size(); ++i)
		{
			const BodyBalance::Contact& c = m_balance.contact(i);
			const Vec3 impulse = c.impulse * c.normal + c.rub, speed = speedAt(c);
			linear += body.inverseMass * impulse;
			angular += body.inverseInertia * cross(c.place - body.center, impulse);
			const double above = dot(speed, c.normal) - c.target;
			EXPECT_GE(c.impulse, 0);
			EXPECT_GE(above, -tolerance);
			EXPECT_LE(above * (c.impulse > 0 ? 1 : 0), tolerance);
			EXPECT_LE(length(c.rub), c.friction * c.impulse * (1 + kExact));
			const Vec3 sliding = speed - dot(speed, c.normal) * c.normal;
			const bool slips = c.friction > 0 && length(sliding) > 5 * tolerance;
			EXPECT_LE(dot(sliding, c.rub) * (slips ? 1 : 0), -0.9 * length(sliding) * c.friction * c.impulse * (slips ? 1 : 0));
		}
		EXPECT_LE(length(linear - m_balance.body().linear), 1e-9);
		EXPECT_LE(length(angular - m_balance.body().angular), 1e-9);
		return true;
	}
	BodyBalance m_balance;
	std::mt19937_64 m_random{1};
};

TEST_F(Balance, OfAnyContacts)
{
	for (int trial = 0; trial < 2000; ++trial)
	{
		std::vector<BodyBalance::Contact> contacts;
		for (int i = 0; i <= trial % 32; ++i) contacts.push_back(contact());
		EXPECT_TRUE(expectBalance(falling(uniform()), contacts));
		if (HasFailure()) FAIL() << trial;
	}
}

// Known before it is solved, and not of what friction may stop, or of what has none.
TEST_F(Balance, WhatSlidesFastSlides)
{
	int fast = 0;
	for (int trial = 0; trial < 2000; ++trial)
	{
		PairBody body = falling({});
		body.linear.x = uniform(0, 30);
		m_balance.start(body);
		for (int i = 0; i <= trial % 8; ++i)
		{
			BodyBalance::Contact flat = contact(trial % 3 == 0 ? 0 : 0.2);
			flat.normal = {0, 1, 0};
			m_balance.add(flat);
		}
		if (!m_balance.slidesFast()) continue;
		++fast;
		EXPECT_TRUE(m_balance.solve() && m_balance.slides()) << trial;
	}
	EXPECT_GT(fast, 300);
	EXPECT_LT(fast, 1300);
}

// As of a ring on a peg: a sweep over rows closes a thousandth of what they lack.
TEST_F(Balance, OfContactsCloseTogether)
{
	for (int trial = 0; trial < 500; ++trial)
	{
		BodyBalance::Contact one = contact(), other = one;
		other.place += 0.02 * uniform();
		other.normal = normalized(one.normal + 0.05 * uniform());
		other.target = one.target + 1e-3 * uniform(-1, 1);
		EXPECT_TRUE(expectBalance(falling(0.1 * uniform()), {one, other}));
		if (HasFailure()) FAIL() << trial;
	}
}

TEST_F(Balance, WithFrictionThatHoldsAndThatSlips)
{
	int held = 0, slipped = 0, wedged = 0;
	for (int trial = 0; trial < 1000; ++trial)
	{
		const double friction = trial % 2 ? 0.1 : 0.7;
		const bool isAnswered = expectBalance(falling(uniform()), {contact(friction), contact(friction)}, kRubbed);
		if (HasFailure()) FAIL() << trial;
		wedged += isAnswered ? 0 : 1;
		if (!isAnswered) continue;
		const BodyBalance::Contact& c = m_balance.contact(0);
		if (c.impulse > 0) ++(length(c.rub) < 0.999 * c.friction * c.impulse ? held : slipped);
	}
	EXPECT_GT(held, 50);
	EXPECT_GT(slipped, 50);
	EXPECT_LT(wedged, 100);
}

// A guess that is right stays as it is; what contacts that do the same have to change is shared.
TEST_F(Balance, ChangesImpulsesByTheLeast)
{
	const BodyBalance::Contact one = contact();
	expectBalance(falling({}), {one, one});
	const double whole = m_balance.contact(0).impulse + m_balance.contact(1).impulse;
	ASSERT_GT(whole, 0);
	BodyBalance::Contact most = one, rest = one;
	most.impulse = 0.8 * whole;
	rest.impulse = 0.2 * whole;
	expectBalance(falling({}), {most, rest});
	EXPECT_NEAR(m_balance.contact(0).impulse, 0.8 * whole, 1e-5 * whole);
	most.impulse = 0.7 * whole;
	expectBalance(falling({}), {most, rest});
	EXPECT_NEAR(m_balance.contact(0).impulse, 0.75 * whole, 1e-5 * whole);
	EXPECT_NEAR(m_balance.contact(1).impulse, 0.25 * whole, 1e-5 * whole);
}

// Between a floor and a ceiling that come nearer. No impulses stop both: those found were some 1e5 times the body's own
// momentum, and a nut that started from them left its thread with 1e5 times its energy.
TEST_F(Balance, OfABodyThatIsJammedIsNone)
{
	for (const double closing : {-0.1, -1e-3, 1e-3, 0.01, 0.1, 1.0})
	{
		const PairBody body = falling({});
		m_balance.start(body);
		const Vec3 up{0, 1, 0};
		m_balance.add({body.center - up, up, {}, closing});
		m_balance.add({body.center + up, -up, {}, closing});
		EXPECT_EQ(m_balance.solve(), closing < 0) << closing;
	}
}

TEST_F(Balance, OfABodyThatCannotTurnIsNone)
{
	PairBody body = falling({});
	body.inverseInertia = {{{}, {}, {}}};
	m_balance.start(body);
	m_balance.add(contact());
	EXPECT_FALSE(m_balance.solve());
}
}  // namespace
}  // namespace clod
