// SPDX-License-Identifier: Zlib
// Reader and writer of POSES.csv, and the hash of a trajectory.
#include "demos/scenes/Poses.h"

#include <xxhash.h>

#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iterator>

namespace clod::demo
{
namespace
{
constexpr std::array<std::string_view, 17> kColumns = {"step", "ax",  "ay",  "az",     "aqx",   "aqy",
													   "aqz",  "aqw", "bx",  "by",     "bz",    "bqx",
													   "bqy",  "bqz", "bqw", "body_a", "body_b"};
constexpr std::size_t kNumbers = 14;  // columns between step and body_a

struct Place
{
	const std::string& name;
	std::size_t line;
	Error error(const std::string& what) const { return {name + ", line " + std::to_string(line) + ": " + what}; }
};

// The next field of a line; advances past the comma.
std::string_view takeField(std::string_view& rest)
{
	const std::size_t comma = rest.find(',');
	const std::string_view field = rest.substr(0, comma);
	rest = comma == std::string_view::npos ? std::string_view{} : rest.substr(comma + 1);
	return field;
}

std::string quoted(std::string_view field)
{
	return "\"" + std::string(field.substr(0, 40)) + "\"";
}

template <class Number>
bool parseWhole(std::string_view field, Number& value)
{
	const char* end = field.data() + field.size();
	const auto [stopped, status] = std::from_chars(field.data(), end, value);
	return status == std::errc{} && stopped == end;
}

// Scales q to length one; false where it is no rounded unit quaternion.
bool normalize(double (&q)[4])
{
	const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
	if (!(std::abs(length - 1) <= kQuaternionTolerance)) return false;
	// Already unit to rounding: keep the bits, so that writing and reading is the identity.
	if (std::abs(length - 1) <= 4e-16) return true;
	for (double& component : q) component /= length;
	return true;
}

Result<Pose> takePose(const double* values, const Place& place, const char* body)
{
	Pose pose{{values[0], values[1], values[2]}, {values[3], values[4], values[5], values[6]}};
	if (!normalize(pose.quaternion))
		return place.error(std::string("quaternion of body ") + body + " is not of unit length");
	return pose;
}

// Which bodies a row is about; empty, or what is wrong.
std::string takeBodies(std::string_view line, std::size_t bodies, PoseRow& row)
{
	std::uint32_t* const values[2] = {&row.bodyA, &row.bodyB};
	for (std::size_t i = 0; i < 2; ++i)
	{
		const std::string_view field = takeField(line);
		if (!parseWhole(field, *values[i]) || *values[i] >= bodies)
			return "column " + std::string(kColumns[kNumbers + 1 + i]) + " is " + quoted(field) +
				   ", expected a body of the scene, 0 to " + std::to_string(bodies - 1);
	}
	return row.bodyA < row.bodyB ? "" : "body_a is not below body_b";
}

Result<PoseRow> parseRow(std::string_view line, std::size_t bodies, const Place& place)
{
	PoseRow row;
	std::array<double, kNumbers> values{};
	std::size_t commas = 0;
	for (const char c : line) commas += c == ',';
	const std::size_t columns = bodies > 2 ? kColumns.size() : kNumbers + 1;
	if (commas + 1 != columns)
		return place.error(std::to_string(commas + 1) + " fields, expected " + std::to_string(columns));
	const std::string_view step = takeField(line);
	if (!parseWhole(step, row.step) || row.step < 0)
		return place.error("column step is " + quoted(step) + ", expected a whole number >= 0");
	for (std::size_t i = 0; i < values.size(); ++i)
	{
		const std::string_view field = takeField(line);
		if (!parseWhole(field, values[i]) || !std::isfinite(values[i]))
			return place.error("column " + std::string(kColumns[i + 1]) + " is " + quoted(field) +
							   ", expected a finite number");
	}
	if (bodies > 2)
		if (const std::string problem = takeBodies(line, bodies, row); !problem.empty()) return place.error(problem);
	const Result<Pose> a = takePose(values.data(), place, "a");
	if (!a) return Error{a.error()};
	const Result<Pose> b = takePose(values.data() + 7, place, "b");
	if (!b) return Error{b.error()};
	row.a = a.value();
	row.b = b.value();
	return row;
}

// The next line without its ending (\n or \r\n).
std::string_view takeLine(std::string_view& rest)
{
	const std::size_t end = rest.find('\n');
	std::string_view line = rest.substr(0, end);
	rest = end == std::string_view::npos ? std::string_view{} : rest.substr(end + 1);
	if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
	return line;
}

void appendNumber(std::string& text, double value)
{
	char buffer[32];
	const auto end = std::to_chars(buffer, buffer + sizeof buffer, value).ptr;
	text += ',';
	text.append(buffer, end);
}

void appendPose(std::string& text, const Pose& pose)
{
	for (int i = 0; i < 3; ++i) appendNumber(text, pose.position[i]);
	for (const double component : pose.quaternion) appendNumber(text, component);
}

const char* headerFor(std::size_t bodies)
{
	return bodies > 2 ? kScenePosesHeader : kPosesHeader;
}
}  // namespace

Result<std::vector<PoseRow>> parsePoses(std::string_view text, const std::string& name, std::size_t bodies)
{
	std::size_t line = 1;
	const char* const header = headerFor(bodies);
	if (takeLine(text) != header) return Place{name, line}.error(std::string("the header is not \"") + header + "\"");
	std::vector<PoseRow> rows;
	while (!text.empty())
	{
		const Place place{name, ++line};
		const Result<PoseRow> row = parseRow(takeLine(text), bodies, place);
		if (!row) return Error{row.error()};
		rows.push_back(row.value());
	}
	if (rows.empty()) return Error{name + ": no poses after the header"};
	return rows;
}

Result<std::vector<PoseRow>> readPoses(const std::string& path, std::size_t bodies)
{
	std::ifstream file(path, std::ios::binary);
	if (!file) return Error{path + ": cannot be opened for reading"};
	const std::string text{std::istreambuf_iterator<char>(file), {}};
	if (file.bad()) return Error{path + ": cannot be read"};
	return parsePoses(text, path, bodies);
}

std::string formatPose(const PoseRow& row)
{
	std::string text = std::to_string(row.step);
	appendPose(text, row.a);
	appendPose(text, row.b);
	return text;
}

std::string formatPoses(const std::vector<PoseRow>& rows, std::size_t bodies)
{
	std::string text = std::string(headerFor(bodies)) + "\n";
	for (const PoseRow& row : rows)
	{
		text += formatPose(row);
		if (bodies > 2) text += "," + std::to_string(row.bodyA) + "," + std::to_string(row.bodyB);
		text += '\n';
	}
	return text;
}

Transform toTransform(const Pose& pose)
{
	const double(&q)[4] = pose.quaternion;
	return {rotationFromQuaternion(q[0], q[1], q[2], q[3]), pose.position};
}

Transform worldFromBody(const Pose& pose, const Vec3& meshFromBody)
{
	Transform transform = toTransform(pose);
	transform.translation = transform * meshFromBody;
	return transform;
}

Transform relativePose(const PoseRow& row, const Vec3& meshFromBodyA, const Vec3& meshFromBodyB)
{
	return inverse(worldFromBody(row.a, meshFromBodyA)) * worldFromBody(row.b, meshFromBodyB);
}

std::string trajectoryHash(const std::vector<Pose>& poses)
{
	std::vector<double> bits;
	for (const Pose& pose : poses)
	{
		for (int i = 0; i < 3; ++i) bits.push_back(pose.position[i]);
		bits.insert(bits.end(), std::begin(pose.quaternion), std::end(pose.quaternion));
	}
	char text[17];
	std::snprintf(text, sizeof text, "%016llx",
				  static_cast<unsigned long long>(XXH3_64bits(bits.data(), bits.size() * sizeof(double))));
	return text;
}

std::string trajectoryHash(const std::vector<PoseRow>& rows)
{
	std::vector<Pose> poses;
	for (const PoseRow& row : rows) poses.insert(poses.end(), {row.a, row.b});
	return trajectoryHash(poses);
}
}  // namespace clod::demo
