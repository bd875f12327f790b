// SPDX-License-Identifier: GPL-3.0-or-later
// Every fault of FaultList.h in a small hierarchy: refused by the loader, named by the checker, or shown harmless.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <set>

#include "builder/Lod.h"
#include "builder/check/Check.h"
#include "tests/check/FaultList.h"
#include "tests/support/Meshes.h"

namespace clod::test
{
namespace
{
HierarchyContent soundContent()
{
	builder::BuildConfig config;
	config.threads = 1;
	const auto silent = [](const char*, double) { return true; };
	// A thin wrinkled ring, sheared so that nothing is symmetric and no inertia zero; walls are thinner than the
	// largest thickness of a face, which would hide them.
	builder::Mesh mesh = wrinkledTorusMesh(1.0, 0.05, 0.01, 3, 24, 8);
	for (Vec3& v : mesh.vertices)
	{
		const Vec3 sheared{v.x + 0.3 * v.y, 1.1 * v.y + 0.2 * v.z, v.z - 0.1 * v.x};
		v = {double(roundToFloat(sheared.x)), double(roundToFloat(sheared.y)), double(roundToFloat(sheared.z))};
	}
	return builder::buildHierarchy(mesh, config, silent);
}

struct Bytes
{
	std::byte* first;
	std::size_t stride, count;
};

template <class T>
Bytes bytesOf(std::vector<T>& records)
{
	return {reinterpret_cast<std::byte*>(records.data()), sizeof(T), records.size()};
}

Bytes recordsOf(HierarchyContent& c, Record record)
{
	switch (record)
	{
		case Record::asset:
			return {reinterpret_cast<std::byte*>(&c.asset), sizeof(Asset), 1};
		case Record::level:
			return bytesOf(c.levels);
		case Record::node:
			return bytesOf(c.nodes);
		case Record::cullBox:
			return bytesOf(c.cullBoxes);
		case Record::face:
			return bytesOf(c.faces);
		case Record::child:
			return bytesOf(c.children);
		case Record::hullX:
			return bytesOf(c.hullX);
		case Record::hullY:
			return bytesOf(c.hullY);
		default:
			return bytesOf(c.hullZ);
	}
}

std::size_t sizeOf(Stored stored)
{
	return stored == Stored::real64 ? 8 : stored == Stored::index16 ? 2 : 4;
}

template <class T>
void spoilReal(std::byte* at, Spoil spoil)
{
	T value;
	std::memcpy(&value, at, sizeof(T));
	const T endless = std::numeric_limits<T>::infinity();
	value = spoil == Spoil::sign ? -value : std::nextafter(value, spoil == Spoil::ulpUp ? endless : -endless);
	std::memcpy(at, &value, sizeof(T));
}

template <class T>
void spoilIndex(std::byte* at, Spoil spoil)
{
	T value;
	std::memcpy(&value, at, sizeof(T));
	value = T(spoil == Spoil::ulpUp ? value + 1 : value - 1);
	std::memcpy(at, &value, sizeof(T));
}

struct Fault
{
	const Field* field;
	Spoil spoil;
	std::size_t element;
	int component;
	std::string name() const
	{
		return std::string(field->name) + " " + std::to_string(component) + " of record " + std::to_string(element) +
			   ": " + kSpoilNames[int(spoil)];
	}
};

// False where the fault changes nothing.
bool plant(HierarchyContent& content, const Fault& fault)
{
	const Field& field = *fault.field;
	const Bytes records = recordsOf(content, field.record);
	const std::size_t size = sizeOf(field.stored);
	const std::size_t next = (fault.element + 1) % records.count;
	std::byte* const at =
		records.first + fault.element * records.stride + field.offset + std::size_t(fault.component) * size;
	std::byte* other = records.first + next * records.stride + field.offset + std::size_t(fault.component) * size;
	if (field.components > 1)
		other = at + (fault.component + 1 < field.components ? std::ptrdiff_t(size)
															 : -std::ptrdiff_t(size) * (field.components - 1));
	const std::vector<std::byte> before(at, at + size);
	const bool isReal = field.stored == Stored::real32 || field.stored == Stored::real64;
	if (fault.spoil == Spoil::omission)
		std::fill(at, at + size, std::byte(0));
	else if (fault.spoil == Spoil::swap)
		std::swap_ranges(at, at + size, other);
	else if (field.stored == Stored::real32)
		spoilReal<float>(at, fault.spoil);
	else if (field.stored == Stored::real64)
		spoilReal<double>(at, fault.spoil);
	else if (fault.spoil == Spoil::sign)
		return false;
	else if (field.stored == Stored::index32)
		spoilIndex<std::uint32_t>(at, fault.spoil);
	else
		spoilIndex<std::uint16_t>(at, fault.spoil);
	if (std::equal(before.begin(), before.end(), at)) return false;
	float was = 0, is = 0;  // -0 and 0 are the same number
	if (isReal && size == 4)
	{
		std::memcpy(&was, before.data(), 4);
		std::memcpy(&is, at, 4);
	}
	return !(isReal && size == 4 && was == is);
}

bool isCaught(const HierarchyContent& content)
{
	const auto hierarchy = Hierarchy::fromBytes(encode(content));
	if (!hierarchy) return true;
	check::Options options;
	options.threads = 1;
	for (const check::Invariant& invariant : check::checkHierarchy(*hierarchy.value(), options))
		if (invariant.violations > 0) return true;
	return false;
}

// One record of the input level, one of the coarsest contact level, each with one component.
std::vector<Fault> allFaults(HierarchyContent& c)
{
	std::size_t coarse = 0;
	while (coarse + 1 < c.levels.size() && (c.levels[coarse + 1].flags & kClodNode) != 0) ++coarse;
	const Level& top = c.levels[coarse];
	std::vector<Fault> faults;
	for (const Field& field : kFields)
	{
		std::vector<std::size_t> elements = {0};
		if (field.record == Record::level) elements = {0, coarse};
		if (field.record == Record::node || field.record == Record::cullBox) elements = {3, top.firstNode + 1};
		if (field.record == Record::face) elements = {5, top.firstFace + 2};
		if (field.record == Record::child) elements = {2, c.nodes[top.firstNode].firstChild};
		if (field.record >= Record::hullX) elements = {9, c.nodes[top.firstNode].firstVertex + 1};
		for (const std::size_t element : elements)
			for (const Spoil spoil : kSpoils)
				faults.push_back(
					{&field, spoil, element, int((element + std::size_t(spoil)) % std::size_t(field.components))});
	}
	return faults;
}
bool isLastBit(const Fault& fault)
{
	const bool isReal = fault.field->stored == Stored::real32 || fault.field->stored == Stored::real64;
	return isReal && (fault.spoil == Spoil::ulpUp || fault.spoil == Spoil::ulpDown);
}

// Why a survivor does no harm.
struct Harmless
{
	const char* name;
	bool onlyLastBit;
	const char* reason;
};
constexpr Harmless kHarmless[] = {
	{"volume", true, "mass properties are compared within 1e-6; a double's last bit is below their own rounding"},
	{"inertia", true, "as volume"},
	{"principal", true, "as volume: still a unit quaternion that diagonalises the inertia within 1e-6"},
	{"thickness", false,
	 "a leaf of none: less than its wall allows, and every bound was proved again with the thin hull"},
	{"hausdorff", false, "upper bound; exchanged with another node's it was proved again"},
	{"axis", false,
	 "of a culling box: every hull was found inside the turned one; a component near zero may turn its sign"},
	{"source", false, "two faces exchange the names of their triangles; no query reads them"},
};

// The entry that says so, or none.
const Harmless* whyHarmless(const Fault& fault)
{
	for (const Harmless& entry : kHarmless)
		if (fault.field->name == std::string(entry.name) && (isLastBit(fault) || !entry.onlyLastBit)) return &entry;
	return nullptr;
}
}  // namespace

TEST(CheckFaultList, WhatSurvivesIsHarmless)
{
	const HierarchyContent sound = soundContent();
	ASSERT_FALSE(isCaught(sound));
	HierarchyContent content = sound;
	std::size_t planted = 0, caught = 0, plantedGross = 0, caughtGross = 0;
	std::set<const Harmless*> needed;
	for (const Fault& fault : allFaults(content))
	{
		content = sound;
		if (!plant(content, fault)) continue;
		const bool found = isCaught(content);
		++planted;
		caught += found ? 1 : 0;
		plantedGross += isLastBit(fault) ? 0 : 1;
		caughtGross += found && !isLastBit(fault) ? 1 : 0;
		// Anything that survived is still proved in full by the checker: isCaught ran every invariant on it.
		const Harmless* const why = found ? nullptr : whyHarmless(fault);
		EXPECT_TRUE(found || why != nullptr) << fault.name();
		if (why != nullptr) needed.insert(why);
		if (!found) std::printf("survivor: %s\n", fault.name().c_str());
	}
	std::printf("%zu of %zu faults caught; %zu of %zu that are more than a real's last bit\n", caught, planted,
				caughtGross, plantedGross);
	EXPECT_EQ(needed.size(), std::size(kHarmless)) << "a reason that excuses no survivor";
	EXPECT_GT(planted, 400u);
	EXPECT_GE(double(caughtGross), 0.98 * double(plantedGross));
	EXPECT_GE(double(caught), 0.95 * double(planted));
}
}  // namespace clod::test
