// SPDX-License-Identifier: GPL-3.0-or-later
// The same solid in every format is the same mesh to the last bit; damaged files are refused.
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <clocale>
#include <cstdlib>
#include <functional>
#include <nlohmann/json.hpp>
#include <random>

#include "builder/intake/Intake.h"
#include "builder/intake/ReadMesh.h"
#include "tests/support/Files.h"
#include "tests/support/Meshes.h"
#include "tests/support/Setting.h"

namespace clod::test
{
namespace
{
using builder::Mesh;
using builder::Soup;

const Mesh& solid()
{
	static const Mesh mesh = boxMesh({0.5, 0.25, 1}, 2);
	return mesh;
}

template <class T>
void append(std::string& bytes, T value, bool bigEndian = false)
{
	std::string raw(reinterpret_cast<const char*>(&value), sizeof(T));
	if (bigEndian) std::reverse(raw.begin(), raw.end());
	bytes += raw;
}

std::string words(const Vec3& v)
{
	return std::to_string(v.x) + " " + std::to_string(v.y) + " " + std::to_string(v.z) + "\n";
}

std::string asObj()
{
	std::string text;
	for (const Vec3& v : solid().vertices) text += "v " + words(v);
	for (const auto& t : solid().triangles)
		text +=
			"f " + std::to_string(t[0] + 1) + " " + std::to_string(t[1] + 1) + " " + std::to_string(t[2] + 1) + "\n";
	return text;
}

std::string faceLines()
{
	std::string text;
	for (const auto& t : solid().triangles)
		text += "3 " + std::to_string(t[0]) + " " + std::to_string(t[1]) + " " + std::to_string(t[2]) + "\n";
	return text;
}

std::string asOff()
{
	std::string text =
		"OFF\n" + std::to_string(solid().vertices.size()) + " " + std::to_string(solid().triangles.size()) + " 0\n";
	for (const Vec3& v : solid().vertices) text += words(v);
	return text + faceLines();
}

std::string plyHeader(const std::string& format)
{
	return "ply\nformat " + format + " 1.0\nelement vertex " + std::to_string(solid().vertices.size()) +
		   "\nproperty double x\nproperty float y\nproperty float z\nproperty uchar red\nelement face " +
		   std::to_string(solid().triangles.size()) + "\nproperty list uchar int vertex_indices\nend_header\n";
}

std::string asPlyText()
{
	std::string text = plyHeader("ascii");
	for (const Vec3& v : solid().vertices)
		text += std::to_string(v.x) + " " + std::to_string(v.y) + " " + std::to_string(v.z) + " 7\n";
	return text + faceLines();
}

std::string asPlyBinary(bool bigEndian)
{
	std::string bytes = plyHeader(bigEndian ? "binary_big_endian" : "binary_little_endian");
	for (const Vec3& v : solid().vertices)
	{
		append(bytes, v.x, bigEndian);
		append(bytes, float(v.y), bigEndian);
		append(bytes, float(v.z), bigEndian);
		append(bytes, std::uint8_t(7));
	}
	for (const auto& t : solid().triangles)
	{
		append(bytes, std::uint8_t(3));
		for (const std::uint32_t v : t) append(bytes, std::int32_t(v), bigEndian);
	}
	return bytes;
}

std::string asStlBinary()
{
	std::string bytes(80, ' ');
	append(bytes, std::uint32_t(solid().triangles.size()));
	for (const auto& t : solid().triangles)
	{
		bytes += std::string(12, '\0');
		for (const std::uint32_t v : t)
			for (int i = 0; i < 3; ++i) append(bytes, float(solid().vertices[v][i]));
		append(bytes, std::uint16_t(0));
	}
	return bytes;
}

std::string asStlText()
{
	std::string text = "solid some name\n";
	for (const auto& t : solid().triangles)
	{
		text += "facet normal 0 0 0\n outer loop\n";
		for (const std::uint32_t v : t) text += "  vertex " + words(solid().vertices[v]);
		text += " endloop\nendfacet\n";
	}
	return text + "endsolid some name\n";
}

std::string asGlb(const std::function<void(nlohmann::json&)>& change = {})
{
	std::string data;
	for (const Vec3& v : solid().vertices)
		for (int i = 0; i < 3; ++i) append(data, float(v[i]));
	const std::size_t positions = data.size();
	for (const auto& t : solid().triangles)
		for (const std::uint32_t v : t) append(data, std::uint16_t(v));
	data.resize((data.size() + 3) / 4 * 4, '\0');
	nlohmann::json scene = {
		{"asset", {{"version", "2.0"}}},
		{"scene", 0},
		{"scenes", {{{"nodes", {0}}}}},
		{"nodes", {{{"mesh", 0}}}},
		{"meshes", {{{"primitives", {{{"attributes", {{"POSITION", 0}}}, {"indices", 1}}}}}}},
		{"accessors",
		 {{{"bufferView", 0}, {"componentType", 5126}, {"count", solid().vertices.size()}, {"type", "VEC3"}},
		  {{"bufferView", 1}, {"componentType", 5123}, {"count", 3 * solid().triangles.size()}, {"type", "SCALAR"}}}},
		{"bufferViews",
		 {{{"buffer", 0}, {"byteOffset", 0}, {"byteLength", positions}},
		  {{"buffer", 0}, {"byteOffset", positions}, {"byteLength", data.size() - positions}}}},
		{"buffers", {{{"byteLength", data.size()}}}}};
	if (change) change(scene);
	std::string json = scene.dump();
	json.resize((json.size() + 3) / 4 * 4, ' ');
	std::string file = "glTF";
	append(file, std::uint32_t(2));
	append(file, std::uint32_t(12 + 8 + json.size() + 8 + data.size()));
	append(file, std::uint32_t(json.size()));
	file += "JSON" + json;
	append(file, std::uint32_t(data.size()));
	return file + std::string("BIN\0", 4) + data;
}

Soup parseGlb(std::string_view bytes)
{
	return builder::parseGltf(bytes, ".");
}

struct Format
{
	const char* name;
	std::string bytes;
	Soup (*parse)(std::string_view);
};

std::vector<Format> formats()
{
	return {{"off", asOff(), builder::parseOff},
			{"ply ascii", asPlyText(), builder::parsePly},
			{"ply little", asPlyBinary(false), builder::parsePly},
			{"ply big", asPlyBinary(true), builder::parsePly},
			{"stl binary", asStlBinary(), builder::parseStl},
			{"stl ascii", asStlText(), builder::parseStl},
			{"glb", asGlb(), parseGlb}};
}
}  // namespace

TEST(IntakeFormats, AgreeToTheBit)
{
	const builder::Intake expected = builder::intake(builder::parseObj(asObj()));
	for (const Format& format : formats())
	{
		const builder::Intake found = builder::intake(format.parse(format.bytes));
		EXPECT_EQ(found.mesh.vertices, expected.mesh.vertices) << format.name;
		EXPECT_EQ(found.mesh.triangles, expected.mesh.triangles) << format.name;
		EXPECT_EQ(found.meshFromBody, expected.meshFromBody) << format.name;
	}
}

// By the ending of the name, however it is written.
TEST(IntakeFormats, FilesAreReadByTheirEndings)
{
	const TemporaryFolder folder;
	const builder::Intake expected = builder::intake(builder::parseObj(asObj()));
	const std::vector<std::pair<const char*, std::string>> files = {
		{"a.obj", asObj()},       {"b.OFF", asOff()},   {"c.ply", asPlyBinary(true)},
		{"d.Stl", asStlBinary()}, {"e.f.glb", asGlb()}, {"g.GLB", asGlb()}};
	for (const auto& [name, bytes] : files)
		EXPECT_EQ(builder::intakeFile(folder.file(name, bytes)).mesh.triangles, expected.mesh.triangles) << name;
	EXPECT_THROW(builder::intakeFile(folder.file("a.dae", asObj())), builder::Refused);
}

// Every shorter file is refused or is, by chance of where text was cut, still the whole solid.
TEST(IntakeFormats, TruncatedFilesAreRefused)
{
	const std::size_t triangles = solid().triangles.size();
	for (const Format& format : formats())
		for (std::size_t size = 0; size + 2 < format.bytes.size(); size += 7) try
			{
				const builder::Intake found =
					builder::intake(format.parse(std::string_view(format.bytes).substr(0, size)));
				EXPECT_EQ(found.mesh.triangles.size(), triangles) << format.name << " cut at " << size;
			}
			catch (const builder::Refused&)
			{
			}
}

// What a careless program may do to a file: bytes changed, dropped, doubled, numbers in text made huge or none, line ends
// of another system, the end cut off. Always a mesh or a reason, in every format.
std::string damaged(std::string bytes, std::mt19937_64& random)
{
	const auto place = [&] { return std::size_t(random() % bytes.size()); };
	for (std::uint64_t count = 1 + random() % 3; count > 0 && !bytes.empty(); --count)
	{
		const std::uint64_t kind = random() % 8;
		// Half of the changes are in the beginning, where headers are.
		const std::size_t at = random() % 2 ? place() : place() % std::min<std::size_t>(bytes.size(), 200);
		const std::size_t length = std::min<std::size_t>(bytes.size() - at, 1 + random() % 40);
		if (kind == 0) bytes[at] = char(random());
		if (kind == 1) bytes[at] = char(bytes[at] ^ (1 << (random() % 8)));
		if (kind == 2) bytes.erase(at, length);
		if (kind == 3) bytes.insert(at, bytes.substr(at, length));
		if (kind == 4) bytes.resize(at);
		if (kind == 5) bytes.insert(at, "\r\n# a comment\r\n");
		if (kind < 6) continue;
		const std::size_t digit = bytes.find_first_of("0123456789", at);
		if (digit == std::string::npos) continue;
		const char* const numbers[] = {"nan", "inf", "-1", "1e999", "4294967295", "18446744073709551616", "1e-320", "."};
		bytes.replace(digit, 1, numbers[random() % std::size(numbers)]);
	}
	return bytes;
}

TEST(IntakeFormats, DamagedFilesAreRefusedWithAReasonOrRead)
{
	std::vector<Format> all = formats();
	all.push_back({"obj", asObj(), builder::parseObj});
	const int starts = setting("CLOD_STARTS", 300);
	int read = 0;
	for (const Format& format : all)
		for (int seed = 0; seed < starts; ++seed)
		{
			std::mt19937_64 random{std::uint64_t(seed)};
			const std::string bytes = damaged(format.bytes, random);
			try
			{
				const builder::Intake found = builder::intake(format.parse(bytes));
				for (const auto& t : found.mesh.triangles)
					for (const std::uint32_t v : t) ASSERT_LT(v, found.mesh.vertices.size()) << format.name << ' ' << seed;
				++read;
			}
			catch (const builder::Refused& refused)
			{
				EXPECT_NE(std::string(refused.what()).find(": "), std::string::npos) << refused.what();
			}
		}
	EXPECT_GT(read, starts / 4);
}

// Of another system's line ends, or with comments in between, a text is the same.
TEST(IntakeFormats, LineEndsAndCommentsChangeNothing)
{
	for (const auto& [parse, text] : {std::pair(&builder::parseObj, asObj()), std::pair(&builder::parseOff, asOff())})
	{
		std::string other;
		for (const char c : text) other += c == '\n' ? " # said\r\n\r\n" : std::string(1, c);
		EXPECT_EQ(builder::intake(parse(other)).mesh.vertices, builder::intake(parse(text)).mesh.vertices);
	}
	for (const auto& [parse, text] : {std::pair(&builder::parsePly, asPlyText()), std::pair(&builder::parseStl, asStlText())})
	{
		std::string other;
		for (const char c : text) other += c == '\n' ? "\r\n" : std::string(1, c);
		EXPECT_EQ(builder::intake(parse(other)).mesh.vertices, builder::intake(parse(text)).mesh.vertices);
	}
}

// What other programs write besides: a mark of the encoding, capitals, blanks, lines that go on.
TEST(IntakeFormats, HabitsOfOtherProgramsChangeNothing)
{
	const TemporaryFolder folder;
	const std::string mark = "\xef\xbb\xbf";
	std::string capitals = asStlText(), goingOn = asObj();
	for (char& c : capitals) c = char(std::toupper(static_cast<unsigned char>(c)));
	for (std::size_t at = 0; (at = goingOn.find("\nf ", at)) != std::string::npos;)
		goingOn.replace(at = goingOn.find(' ', at + 3), 1, "\\\n");
	const std::pair<const char*, std::string> files[] = {
		{"mark.obj", mark + "# made by\n" + asObj()}, {"mark.off", mark + asOff()}, {"mark.stl", mark + asStlText()},
		{"mark.ply", mark + asPlyText()},             {"capitals.stl", capitals},   {"blanks.stl", "\r\n " + asStlText()},
		{"lines.obj", goingOn}};
	for (const auto& [name, text] : files)
		EXPECT_EQ(builder::intakeFile(folder.file(name, text)).mesh.triangles.size(), solid().triangles.size()) << name;
}

// The header of a binary STL file is free: what stands there is no mark.
TEST(IntakeFormats, BinaryStlMayBeginLikeAMark)
{
	const TemporaryFolder folder;
	std::string bytes = asStlBinary();
	bytes.replace(0, 3, "\xef\xbb\xbf");
	EXPECT_EQ(builder::intakeFile(folder.file("a.stl", bytes)).mesh.triangles.size(), solid().triangles.size());
}

// In Turkish, the small letter of I is another one.
TEST(IntakeFormats, CapitalsAreReadInAnyLocale)
{
	const TemporaryFolder folder;
	const std::string make = "localedef -i tr_TR -f ISO-8859-9 --no-archive " + folder.file("tr") + " 2>&1";
	if (std::system(make.c_str()) != 0) GTEST_SKIP() << "no Turkish locale can be made here";
	std::string text = asStlText();
	for (char& c : text) c = char(std::toupper(static_cast<unsigned char>(c)));
	const std::string path = folder.file("A.STL", text);
	setenv("LOCPATH", folder.path().c_str(), 1);
	ASSERT_NE(std::setlocale(LC_CTYPE, "tr"), nullptr);
	ASSERT_NE(std::tolower('I'), 'i');
	std::size_t triangles = 0;
	std::string refusal;
	try
	{
		triangles = builder::intakeFile(path).mesh.triangles.size();
	}
	catch (const builder::Refused& refused)
	{
		refusal = refused.what();
	}
	std::setlocale(LC_CTYPE, "C");
	unsetenv("LOCPATH");
	EXPECT_EQ(triangles, solid().triangles.size()) << refusal;
}

TEST(IntakeFormats, GltfNodesOnlyMove)
{
	const std::string moved = asGlb(
		[](nlohmann::json& scene)
		{
			scene["nodes"] = {{{"children", {1}}, {"translation", {1, 2, 3}}}, {{"mesh", 0}}};
		});
	const builder::Intake found = builder::intake(builder::parseGltf(moved, ".")),
						  expected = builder::intake(builder::parseGltf(asGlb(), "."));
	EXPECT_EQ(found.mesh.triangles, expected.mesh.triangles);
	EXPECT_NEAR(length(found.meshFromBody - expected.meshFromBody - Vec3{1, 2, 3}), 0, 1e-6);
}

TEST(IntakeFormats, GltfWithAnyNumberBeyondWhatThereIsIsRefused)
{
	for (const char* number :
		 {"/scene", "/scenes/0/nodes/0", "/nodes/0/mesh", "/meshes/0/primitives/0/indices",
		  "/meshes/0/primitives/0/attributes/POSITION", "/accessors/0/bufferView", "/accessors/1/bufferView",
		  "/accessors/0/count", "/accessors/1/count", "/accessors/0/componentType", "/bufferViews/0/buffer",
		  "/bufferViews/1/byteOffset", "/bufferViews/1/byteLength", "/buffers/0/byteLength"})
		for (const int wrong : {7, 99, 100000, 2147483647})
		{
			const std::string bytes =
				asGlb([&](nlohmann::json& scene) { scene[nlohmann::json::json_pointer(number)] = wrong; });
			EXPECT_THROW(builder::intake(builder::parseGltf(bytes, ".")), builder::Refused) << number << ' ' << wrong;
		}
}

TEST(IntakeFormats, CountsBeyondTheFileAreRefusedBeforeAnythingIsAllocated)
{
	EXPECT_THROW(builder::parseOff("OFF\n4000000000 1 0\n0 0 0\n"), builder::Refused);
	EXPECT_THROW(
		builder::parsePly("ply\nformat ascii 1.0\nelement vertex 4000000000000\nproperty float x\nproperty float "
						  "y\nproperty float z\nend_header\n0 0 0\n"),
		builder::Refused);
	std::string list =
		"ply\nformat binary_little_endian 1.0\nelement face 1\nproperty list uint int vertex_indices\nend_header\n";
	append(list, std::uint32_t(0xFFFFFFFF));
	EXPECT_THROW(builder::parsePly(list), builder::Refused);
	std::string stl(80, ' ');
	append(stl, std::uint32_t(0xFFFFFFFF));
	EXPECT_THROW(builder::parseStl(stl), builder::Refused);
}
}  // namespace clod::test
