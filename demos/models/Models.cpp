// SPDX-License-Identifier: Zlib
#include "demos/models/Models.h"

#include <algorithm>
#include <cstdio>

#include "demos/models/Mechanisms.h"
#include "demos/models/Shapes.h"
#include "demos/models/Sweep.h"

namespace clod::demo
{
namespace
{
constexpr size_t MAX_TRIANGLES = 20000000;
constexpr size_t DIGIT_TRIANGLES = 1080, DIGIT_MIN_TRIANGLES = 500;

struct Entry
{
	const char* name;
	size_t defaultTriangles;
	size_t minTriangles;
};
const Entry PAPER_MODELS[] = {
	{"cup", 64000, 1000}, {"spoon", 86016, 500}, {"spiral", 32160, 500}, {"torus", 32000, 60}, {"bowl", 12288, 200}};
const Entry TEST_SHAPES[] = {{"bolt", 33792, 1000},     {"nut", 16000, 1000}, {"slab", 10000, 12},
							 {"floor", 240, 240},       {"box", 1200, 12},    {"sphere", 1200, 12},
							 {"smooth-torus", 3200, 60}, {"landscape", 65536, 2000}};

// The size limits of a name; a null name: unknown.
Entry findEntry(const std::string& name)
{
	for (const Entry& e : PAPER_MODELS)
		if (name == e.name) return e;
	for (const Entry& e : TEST_SHAPES)
		if (name == e.name) return e;
	if (const ModelMaker part = mechanismPart(name); part.make)
		return {"part", part.defaultTriangles, part.minTriangles};
	const bool isDigit = name.size() == 7 && name.compare(0, 6, "number") == 0 && name[6] >= '0' && name[6] <= '9';
	return isDigit ? Entry{"number", DIGIT_TRIANGLES, DIGIT_MIN_TRIANGLES} : Entry{nullptr, 0, 0};
}

ModelMesh makeShape(const std::string& name, size_t triangles)
{
	if (name == "cup") return makeCup(triangles);
	if (name == "spoon") return makeSpoon(triangles);
	if (name == "spiral") return makeSpiral(triangles);
	if (name == "torus") return makeTorus(triangles, TORUS_WRINKLE);
	if (name == "smooth-torus") return makeTorus(triangles, 0);
	if (name == "bowl") return makeBowl(triangles);
	if (name == "bolt") return makeBolt(triangles);
	if (name == "nut") return makeNut(triangles);
	if (name == "slab" || name == "floor") return makeBox({0.2, 0.02, 0.2}, triangles);
	if (name == "landscape") return makeLandscape(triangles);
	if (name == "box") return makeBox({0.02, 0.02, 0.02}, triangles);
	if (name == "sphere") return makeSphere(triangles, 0.01);
	if (const ModelMaker part = mechanismPart(name); part.make) return part.make(triangles);
	return makeDigit(name[6] - '0', triangles);
}

std::string knownNames()
{
	std::string list;
	for (const auto* names : {&modelNames(), &testShapeNames()})
		for (const std::string& n : *names) list += (list.empty() ? "" : " ") + n;
	return list;
}
}  // namespace

const std::vector<std::string>& modelNames()
{
	static const std::vector<std::string> names = []
	{
		std::vector<std::string> list;
		for (const Entry& e : PAPER_MODELS) list.push_back(e.name);
		for (char digit = '0'; digit <= '9'; ++digit) list.push_back(std::string("number") + digit);
		return list;
	}();
	return names;
}

const std::vector<std::string>& testShapeNames()
{
	static const std::vector<std::string> names = []
	{
		std::vector<std::string> list;
		for (const Entry& e : TEST_SHAPES) list.push_back(e.name);
		for (const ModelMaker& part : mechanismParts()) list.push_back(part.name);
		return list;
	}();
	return names;
}

size_t paperTriangleCount(const std::string& name)
{
	return findEntry(name).defaultTriangles;
}

size_t smallestTriangleCount(const std::string& name)
{
	return findEntry(name).minTriangles;
}

Result<ModelMesh> makeModel(const std::string& name, size_t triangles)
{
	const Entry entry = findEntry(name);
	if (entry.name == nullptr) return Error{"Unknown model \"" + name + "\"; known: " + knownNames() + "."};
	const size_t wanted = triangles == 0 ? entry.defaultTriangles : triangles;
	if (wanted < entry.minTriangles || wanted > MAX_TRIANGLES)
		return Error{"Model " + name + ": " + std::to_string(wanted) + " triangles asked, possible are " +
					 std::to_string(entry.minTriangles) + " to " + std::to_string(MAX_TRIANGLES) + "."};
	ModelMesh mesh = makeShape(name, wanted);
	if (mesh.triangles.empty())
		return Error{"Model " + name + " cannot be built with " + std::to_string(wanted) + " triangles."};
	orientOutward(mesh);
	return mesh;
}

std::string toObj(const ModelMesh& mesh)
{
	std::string text = "# Closed triangle mesh, metres, y up: " + std::to_string(mesh.vertices.size()) + " vertices, " +
					   std::to_string(mesh.triangles.size()) + " triangles\n";
	char line[128];
	for (const Vec3& v : mesh.vertices)
	{
		std::snprintf(line, sizeof line, "v %.17g %.17g %.17g\n", v.x, v.y, v.z);
		text += line;
	}
	for (const auto& t : mesh.triangles)
	{
		std::snprintf(line, sizeof line, "f %u %u %u\n", t[0] + 1, t[1] + 1, t[2] + 1);
		text += line;
	}
	return text;
}
}  // namespace clod::demo
