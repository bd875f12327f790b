// SPDX-License-Identifier: Zlib
// Separating axes of one box against eight. For InstructionSets.h: no include guard.

using Lanes = float __attribute__((vector_size(32)));
using Bits = std::int32_t __attribute__((vector_size(32)));

struct Axis
{
	Lanes x, y, z;
};
// Boxes in frame A.
struct Boxes
{
	Axis center, axis[3], move;
	Lanes half[3], radius, spread;
};

CLOD_INLINED void all(float x, Lanes& r)
{
	r = Lanes{} + x;
}
CLOD_INLINED void magnitude(Lanes& x)
{
	x = Lanes(Bits(x) & 0x7FFFFFFF);
}
CLOD_INLINED void larger(Lanes& x, const Lanes& y)
{
	x = x > y ? x : y;
}
CLOD_INLINED void product(const Axis& a, const Axis& b, Lanes& r)
{
	r = a.x * b.x + a.y * b.y + a.z * b.z;
}
CLOD_INLINED void rootOf(Lanes& x)
{
#ifdef CLOD_WIDE
	x = _mm256_sqrt_ps(x);
#else
	for (int i = 0; i < 8; ++i) x[i] = std::sqrt(x[i]);
#endif
}

// Bit i: lane i of a comparison.
CLOD_INLINED std::uint32_t bitsOf(const Bits& mask)
{
#ifdef CLOD_WIDE
	return std::uint32_t(_mm256_movemask_ps((__m256)mask));
#else
	std::uint32_t bits = 0;
	for (int i = 0; i < 8; ++i) bits |= mask[i] != 0 ? 1U << i : 0;
	return bits;
#endif
}

// Eight rows of eight numbers become eight columns.
CLOD_INLINED void transpose(Lanes (&m)[8])
{
	Lanes t[8], s[8];
	for (std::size_t i = 0; i < 4; ++i)
	{
		t[2 * i] = __builtin_shufflevector(m[2 * i], m[2 * i + 1], 0, 8, 1, 9, 4, 12, 5, 13);
		t[2 * i + 1] = __builtin_shufflevector(m[2 * i], m[2 * i + 1], 2, 10, 3, 11, 6, 14, 7, 15);
	}
	for (std::size_t i = 0; i < 2; ++i)
		for (std::size_t k = 0; k < 2; ++k)
		{
			s[4 * i + 2 * k] = __builtin_shufflevector(t[4 * i + k], t[4 * i + k + 2], 0, 1, 8, 9, 4, 5, 12, 13);
			s[4 * i + 2 * k + 1] = __builtin_shufflevector(t[4 * i + k], t[4 * i + k + 2], 2, 3, 10, 11, 6, 7, 14, 15);
		}
	for (int i = 0; i < 4; ++i)
	{
		m[i] = __builtin_shufflevector(s[i], s[i + 4], 0, 1, 2, 3, 8, 9, 10, 11);
		m[i + 4] = __builtin_shufflevector(s[i], s[i + 4], 4, 5, 6, 7, 12, 13, 14, 15);
	}
}

CLOD_INLINED void spreadOver(const OrientedBox& box, Boxes& r)
{
	all(box.center[0], r.center.x), all(box.center[1], r.center.y), all(box.center[2], r.center.z);
	all(box.radius, r.radius);
	for (int i = 0; i < 3; ++i)
	{
		all(box.axis[i][0], r.axis[i].x), all(box.axis[i][1], r.axis[i].y), all(box.axis[i][2], r.axis[i].z);
		all(box.half[i], r.half[i]);
	}
}
// Lanes beyond count repeat the last box.
CLOD_INLINED void gather(const OrientedBox* const* boxes, std::uint32_t count, Boxes& r)
{
	static_assert(sizeof(OrientedBox) == 2 * sizeof(Lanes));
	Lanes low[8], high[8];
	for (std::uint32_t i = 0; i < kBoxLanes; ++i)
	{
		const char* const bytes = reinterpret_cast<const char*>(boxes[i < count ? i : count - 1]);
		std::memcpy(&low[i], bytes, sizeof(Lanes));
		std::memcpy(&high[i], bytes + sizeof(Lanes), sizeof(Lanes));
	}
	transpose(low);
	transpose(high);
	r.center = {low[0], low[1], low[2]};
	r.radius = low[3];
	r.axis[0] = {low[4], low[5], low[6]};
	r.axis[1] = {low[7], high[0], high[1]};
	r.axis[2] = {high[2], high[3], high[4]};
	for (int i = 0; i < 3; ++i) r.half[i] = high[5 + i];
}

CLOD_INLINED void turned(const BoxFrame& frame, Axis& v)
{
	const Axis before = v;
	const auto& r = frame.rotation;
	v.x = before.x * r[0][0] + before.y * r[0][1] + before.z * r[0][2];
	v.y = before.x * r[1][0] + before.y * r[1][1] + before.z * r[1][2];
	v.z = before.x * r[2][0] + before.y * r[2][1] + before.z * r[2][2];
}
// Boxes of B into frame A.
CLOD_INLINED void place(const BoxFrame& frame, Boxes& boxes)
{
	for (Axis& axis : boxes.axis) turned(frame, axis);
	turned(frame, boxes.center);
	Axis& c = boxes.center;
	c.x += frame.translation[0], c.y += frame.translation[1], c.z += frame.translation[2];
	if (!frame.moves) return;
	const auto& w = frame.angular;
	boxes.move.x = c.z * w[1] - c.y * w[2] + frame.linear[0];
	boxes.move.y = c.x * w[2] - c.z * w[0] + frame.linear[1];
	boxes.move.z = c.y * w[0] - c.x * w[1] + frame.linear[2];
	boxes.spread = boxes.radius * frame.turn;
}

// How far two centres are apart along an axis, whichever way round, when one comes nearer by `move` on the way.
CLOD_INLINED void apartAlong(const Axis& axis, const Axis& between, const Axis* move, Lanes& r)
{
	product(axis, between, r);
	if (!move)
	{
		magnitude(r);
		return;
	}
	Lanes way;
	product(axis, *move, way);
	const Lanes zero{}, end = r + way;
	const Lanes up = way < zero ? end : r, down = way < zero ? -r : -end;
	r = up > down ? up : down;
}

// Of the origin from the segment between p and p + move.
CLOD_INLINED void toSegment(const Axis& from, const Axis& move, Lanes& distance)
{
	Axis p = from;
	const Lanes zero{}, one = zero + 1.0F;
	Lanes along, squared;
	product(p, move, along);
	product(move, move, squared);
	along = -along;
	const Lanes share = along <= zero ? zero : along >= squared ? one : along / squared;
	p.x += share * move.x, p.y += share * move.y, p.z += share * move.z;
	product(p, p, distance);
	rootOf(distance);
}

CLOD_INLINED void separate(const BoxFrame& frame, const Boxes& a, const Boxes& b, Lanes& result)
{
	const Axis between{b.center.x - a.center.x, b.center.y - a.center.y, b.center.z - a.center.z};
	const Axis* const move = frame.moves ? &b.move : nullptr;
	const Lanes radii = a.radius + b.radius;
	Lanes distance, size = radii, slack{};
	if (move)
	{
		Lanes way;
		toSegment(between, b.move, distance);
		product(b.move, b.move, way);
		rootOf(way);
		size += way;
		slack = b.spread;
	}
	else
	{
		product(between, between, distance);
		rootOf(distance);
	}
	slack += (size + distance) * float(kRounding) + frame.rounding;
	result = distance - radii;
	Lanes extentA[3]{};
	for (int i = 0; i < 3; ++i)
	{
		Lanes extentB{}, apart;
		for (int j = 0; j < 3; ++j)
		{
			Lanes cosine;
			product(a.axis[i], b.axis[j], cosine);
			magnitude(cosine);
			extentB += cosine * b.half[j];
			extentA[j] += cosine * a.half[i];
		}
		apartAlong(a.axis[i], between, move, apart);
		larger(result, apart - a.half[i] - extentB);
	}
	for (int j = 0; j < 3; ++j)
	{
		Lanes apart;
		apartAlong(b.axis[j], between, move, apart);
		larger(result, apart - b.half[j] - extentA[j]);
	}
	result -= slack;
}

std::uint32_t boxSeparations(const BoxFrame& frame, const OrientedBox& one, bool oneIsOfA,
							 const OrientedBox* const* others, std::uint32_t count, float* separations, float limit)
{
	Boxes single, row;
	spreadOver(one, single);
	gather(others, count, row);
	place(frame, oneIsOfA ? row : single);
	Lanes result;
	separate(frame, oneIsOfA ? single : row, oneIsOfA ? row : single, result);
	std::memcpy(separations, &result, sizeof result);
	return bitsOf(result <= limit) & ((1U << count) - 1);
}
