// SPDX-License-Identifier: Zlib
// What a frame shows and says.
#include "demos/runner/Frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <set>
#include <utility>

#include "cli/Counted.h"
#include "cli/Failure.h"
#include "demos/render/MetricLength.h"
#include "demos/runner/Selection.h"
#include "demos/scenes/SceneDefinition.h"

namespace clod::demo
{
namespace
{
constexpr int kPanel = kViewImageHeight;  // pixels, each way
constexpr Color kGlassColor = {0.45f, 0.62f, 0.78f, 0.22f};
// Neighbours differ: a chain's links, what lies between two others. So do their patches, by so much of the way to
// white.
constexpr Color kSolidColors[] = {{0.72f, 0.74f, 0.77f, 1}, {0.58f, 0.57f, 0.55f, 1}, {0.80f, 0.73f, 0.64f, 1}};
constexpr float kPaler[] = {0, 0.3f, 0.15f};
constexpr Color kContactColor = {0.85f, 0.1f, 0.1f, 1};
// Arrows point from A to B: the way A pushes B.
constexpr double kMarkerSpacing = 2.0 / 15;  // of the close-up's radius
constexpr std::size_t kLargestMarkers = 40;
constexpr std::size_t kCrowd = 100;  // more arrows would hide what they point at
// Ground lines a decade under the picture's size; where they fade.
constexpr double kGridShare = 0.1, kFadeShare = 4.2;
constexpr double kExactShare = 1e-5;  // of the smallest radius: errors that small have one colour
constexpr const char* kColorsMean = "Coloured: the surface patches in contact, by certified error. ";
constexpr const char* kHatchedMeans = "Hatched: hidden. ";
constexpr const char* kCarry = "contact points under load";
constexpr const char* kNearest = "where patches are nearest to each other";
constexpr const char* kArrowsMean = ", with the push of one body on the other";

constexpr Color kGhostColor = {0.5f, 0.55f, 0.65f, 0.12f};
// Of an exploded picture: between bodies, of what it shows; between a body's patches, of the way to their middle.
constexpr double kPulledApart = 0.35, kSpread = 0.3;

Result<MeshId> upload(Renderer& renderer, const ModelMesh& mesh)
{
	RenderMesh render;
	render.vertices = mesh.vertices;
	render.triangles = mesh.triangles;
	return renderer.addMesh(render);
}

PatchLayer patchLayer(const Pose& pose, const Hierarchy& hierarchy, const std::set<std::uint32_t>& nodes,
					  const ErrorScale& scale, std::size_t body, bool isSeenThrough)
{
	const auto paler = [&](float v) { return v + kPaler[body % std::size(kPaler)] * (1 - v); };
	PatchLayer layer;
	layer.worldFromBody = worldFromBody(pose, meshFromBody(hierarchy));
	layer.isSeenThrough = isSeenThrough;
	for (const std::uint32_t index : nodes)
	{
		const Node& node = hierarchy.node(index);
		const HullView hull = hierarchy.hull(node);
		const Color plain = scale.color(scale.stepOf(double(node.deviation)));
		const Color color = variedByIndex({paler(plain.r), paler(plain.g), paler(plain.b), 1}, index);
		for (const Face& face : hierarchy.faces(node))
			layer.triangles.push_back(
				{{hull.vertex(face.vertex[0]), hull.vertex(face.vertex[1]), hull.vertex(face.vertex[2])}, color});
	}
	return layer;
}

Camera overviewAt(const FrameSubject& subject, std::int64_t step)
{
	const double way = partOfWay(step, subject.steps);
	Camera camera = subject.overview;
	camera.eye += way * (subject.overviewAtEnd.eye - camera.eye);
	camera.target += way * (subject.overviewAtEnd.target - camera.target);
	camera.fovy += way * (subject.overviewAtEnd.fovy - camera.fovy);
	return camera;
}

std::string gapInWords(const ReplayRow& row)
{
	if (!std::isfinite(row.minDistance)) return "not in contact";
	if (!std::isfinite(row.errorBound)) return "overlapping; the depth is not proved";
	const std::string size = metricLength(std::fabs(row.minDistance), 2);
	return (row.minDistance < 0 ? "overlap " : "gap ") + size + ", certified to within " + metricLength(row.errorBound, 2);
}

std::vector<std::string> figures(const FrameAnswer& answer)
{
	const ReplayRow& row = answer.row;
	std::vector<std::string> lines;
	lines.push_back("selection: " + answer.selection);
	lines.push_back(gapInWords(row));
	if (row.contacts == 0 && row.tests() == 0) return lines;
	const std::string touching = cli::counted(row.contacts, "touching patch pair");
	const std::string ofPairs = ", " + cli::counted(answer.pairs.size(), "pair") + " of bodies";
	lines.push_back(touching + (answer.pairs.size() == 1 ? "" : ofPairs));
	const double us = row.queryMicroseconds;
	const std::string tests = row.tests() == 1 ? "1 hull or box" : fmt::format("{} hulls and boxes", row.tests());
	lines.push_back("query: " + tests + " compared, " +
					(us < 1e4 ? fmt::format("{:.0f} µs", us) : fmt::format("{:.0f} ms", us / 1000)) + " by the clock");
	return lines;
}

// Nodes of each body that answered; none of a body that is one convex patch, which would be coloured all over, as the
// floor it lies on would.
std::vector<std::set<std::uint32_t>> answeringNodes(const FrameSubject& subject, const FrameAnswer& answer)
{
	std::vector<std::set<std::uint32_t>> nodes(subject.bodies.size());
	for (const PairAnswer& pair : answer.pairs)
		for (const Contact& contact : pair.result.contacts)
		{
			nodes[pair.bodies.a].insert(contact.nodeA);
			nodes[pair.bodies.b].insert(contact.nodeB);
		}
	for (std::size_t i = 0; i < nodes.size(); ++i)
		if (subject.bodies[i].hierarchy->levels()[0].nodeCount == 1) nodes[i].clear();
	return nodes;
}

// In a pile, what is behind only confuses.
bool isPair(const FrameSubject& subject)
{
	return subject.bodies.size() == 2;
}

// A body's way from the others: against the contacts' normals of B, along those of A.
Vec3 wayFromOthers(const FrameSubject& subject, const FrameMoment& moment, const FrameAnswer& answer, std::size_t body)
{
	Vec3 way;
	for (const PairAnswer& pair : answer.pairs)
		for (const Contact& contact : pair.result.contacts)
		{
			const double side = body == pair.bodies.a ? 1 : body == pair.bodies.b ? -1 : 0;
			const Transform worldFromA =
				worldFromBody(moment.poses[pair.bodies.a], meshFromBody(*subject.bodies[pair.bodies.a].hierarchy));
			way += side * (worldFromA.rotation * contact.normal);
		}
	return normalized(way);
}

// Moves the patches of a layer from their middle. A patch's faces stand together, in one colour.
void pullPatchesApart(PatchLayer& layer)
{
	Vec3 middle;
	for (const ColoredTriangle& triangle : layer.triangles)
		for (const Vec3& corner : triangle.corners) middle += (1 / (3 * double(layer.triangles.size()))) * corner;
	const auto isSame = [](const Color& c, const Color& d) { return c.r == d.r && c.g == d.g && c.b == d.b; };
	for (std::size_t first = 0; first < layer.triangles.size();)
	{
		std::size_t end = first;
		Vec3 center;
		for (; end < layer.triangles.size() && isSame(layer.triangles[end].color, layer.triangles[first].color); ++end)
			for (const Vec3& corner : layer.triangles[end].corners) center += corner;
		const Vec3 shift = kSpread * ((1 / (3 * double(end - first))) * center - middle);
		for (; first < end; ++first)
			for (Vec3& corner : layer.triangles[first].corners) corner += shift;
	}
}

// Of an error above 0 the first of ... 0.3, 1, 3, 10 ... that is no smaller, counted from 1.
int halfDecades(double error)
{
	const int decade = int(std::floor(std::log10(error)));
	const double mantissa = error * std::pow(10.0, -decade);
	return 2 * decade + (mantissa <= 1 ? 0 : mantissa <= 3 ? 1 : 2);
}
}  // namespace

Camera overviewCamera(const SceneView& view)
{
	return orbitCamera(view.center, view.radius, view.azimuth, view.elevation);
}

ErrorScale::ErrorScale(const FrameSubject& subject)
{
	double smallest = kOff, most = 0;
	for (const FrameBody& body : subject.bodies)
	{
		smallest = std::min(smallest, double(body.hierarchy->asset().radius));
		for (std::uint32_t level = 0; level <= body.hierarchy->coarsestClodLevel(); ++level)
		{
			const Level& all = body.hierarchy->levels()[level];
			for (std::uint32_t i = 0; i < all.nodeCount; ++i)
			{
				const double error = double(body.hierarchy->node(all.firstNode + i).deviation);
				if (std::isfinite(error)) most = std::max(most, error);
			}
		}
	}
	most = std::min(most, subject.largestError);
	m_first = halfDecades(kExactShare * smallest);
	m_steps = 1 + std::max(0, halfDecades(std::max(most, kExactShare * smallest)) - m_first);
}

int ErrorScale::stepOf(double error) const
{
	return error > 0 ? std::clamp(halfDecades(error) - m_first, 0, m_steps - 1) : 0;
}

double ErrorScale::largestOf(int step) const
{
	const int half = m_first + step, decade = half >= 0 ? half / 2 : (half - 1) / 2;
	return (half - 2 * decade == 1 ? 3 : 1) * std::pow(10.0, decade);
}

std::vector<LegendEntry> legendOf(const FrameSubject& subject, const FrameAnswer& answer)
{
	const ErrorScale scale(subject);
	std::set<int> used;
	const std::vector<std::set<std::uint32_t>> nodes = answeringNodes(subject, answer);
	for (std::size_t body = 0; body < nodes.size(); ++body)
		for (const std::uint32_t node : nodes[body])
			used.insert(scale.stepOf(double(subject.bodies[body].hierarchy->node(node).deviation)));
	std::vector<LegendEntry> entries;
	for (const int step : used)
		entries.push_back({scale.color(step), "up to " + metricLength(scale.largestOf(step))});
	return entries;
}

std::string footnoteOf(const FrameSubject& subject, const FrameAnswer& answer, std::size_t contacts,
					   const std::string& redMeans)
{
	std::string words;
	if (!legendOf(subject, answer).empty()) words = kColorsMean + std::string(isPair(subject) ? kHatchedMeans : "");
	if (contacts > 0) words += "Red: " + redMeans + (contacts > kCrowd ? "." : std::string(kArrowsMean) + ".");
	return words;
}

double largestErrorShown(const FrameSubject& subject, const FrameAnswer& answer)
{
	double most = 0;
	const std::vector<std::set<std::uint32_t>> nodes = answeringNodes(subject, answer);
	for (std::size_t i = 0; i < nodes.size(); ++i)
		for (const std::uint32_t node : nodes[i])
			most = std::max(most, double(subject.bodies[i].hierarchy->node(node).deviation));
	return most;
}

std::size_t patchesShown(const FrameSubject& subject, const FrameAnswer& answer)
{
	std::size_t count = 0;
	for (const std::set<std::uint32_t>& nodes : answeringNodes(subject, answer)) count += nodes.size();
	return count;
}

const PairAnswer& pairThatShowsMost(const FrameSubject& subject, const FrameAnswer& answer)
{
	const auto shownOf = [&](const PairAnswer& pair)
	{
		const FrameAnswer alone{"", {pair}, {}};
		const std::vector<std::set<std::uint32_t>> nodes = answeringNodes(subject, alone);
		const bool isOfBoth = !nodes[pair.bodies.a].empty() && !nodes[pair.bodies.b].empty();
		return std::make_pair(isOfBoth, patchesShown(subject, alone));
	};
	const auto showsLess = [&](const PairAnswer& l, const PairAnswer& r) { return shownOf(l) < shownOf(r); };
	return *std::max_element(answer.pairs.begin(), answer.pairs.end(), showsLess);
}

FramePainter::FramePainter(const FrameSubject& subject) : m_subject(subject), m_scale(subject)
{
	auto renderer = Renderer::create(kPanel, kPanel);
	if (!renderer) throw cli::Failure(cli::ExitCode::failure, renderer.error());
	m_renderer = std::move(renderer.value());
	for (const ModelMesh& mesh : subject.meshes)
	{
		const Result<MeshId> id = upload(*m_renderer, mesh);
		if (!id) throw cli::Failure(cli::ExitCode::failure, id.error());
		m_meshes.push_back(id.value());
	}
}

void FramePainter::addPatches(Frame& frame, const FrameMoment& moment, const FrameAnswer& answer) const
{
	const std::vector<std::set<std::uint32_t>> nodes = answeringNodes(m_subject, answer);
	for (std::size_t i = 0; i < nodes.size(); ++i)
	{
		const Hierarchy& hierarchy = *m_subject.bodies[i].hierarchy;
		// A layer for every error: a body may answer one neighbour coarsely, another finely at the same place.
		std::map<int, std::set<std::uint32_t>> nodesOf;
		for (const std::uint32_t node : nodes[i])
			nodesOf[m_scale.stepOf(double(hierarchy.node(node).deviation))].insert(node);
		for (const auto& [step, ofStep] : nodesOf)
		{
			PatchLayer layer = patchLayer(moment.poses[i], hierarchy, ofStep, m_scale, i, isPair(m_subject));
			layer.isGlass = m_subject.bodies[i].isSeenThrough;
			for (const std::uint32_t node : ofStep)
				layer.deviation = std::max(layer.deviation, double(hierarchy.node(node).deviation));
			frame.patches.push_back(std::move(layer));
		}
	}
}

void FramePainter::addContacts(Frame& frame, const std::vector<FrameContact>& contacts) const
{
	const double size = m_subject.closeUp.radius;
	const bool isCrowded = contacts.size() > kCrowd;
	for (const FrameContact& contact : contacts)
	{
		frame.markers.push_back({contact.position, (isCrowded ? 0.010 : 0.016) * size, kContactColor});
		if (isCrowded) continue;
		frame.arrows.push_back(
			{contact.position, contact.position - (0.25 * size) * contact.normal, 0.007 * size, kContactColor});
	}
}

Frame FramePainter::scene(const FrameMoment& moment, const FrameAnswer& answer) const
{
	Frame frame;
	frame.camera = overviewAt(m_subject, moment.step);
	const double size = length(frame.camera.eye - frame.camera.target) * std::tan(frame.camera.fovy * kPi / 360);
	frame.ground.isDrawn = m_subject.hasGround;
	frame.ground.spacing = std::pow(10.0, std::round(std::log10(kGridShare * size)));
	frame.ground.fadeRadius = kFadeShare * size;
	for (std::size_t i = 0; i < m_subject.bodies.size(); ++i)
	{
		const FrameBody& body = m_subject.bodies[i];
		const Color& color = body.isSeenThrough ? kGlassColor : kSolidColors[i % std::size(kSolidColors)];
		frame.instances.push_back({m_meshes[body.mesh], toTransform(moment.poses[i]), color, body.isSeenThrough});
	}
	addPatches(frame, moment, answer);
	return frame;
}

Image FramePainter::overview(const FrameMoment& moment, const FrameAnswer& answer,
							 const std::vector<FrameContact>& contacts, const std::string& redMeans,
							 const std::vector<std::string>& lines)
{
	Frame frame = scene(moment, answer);
	addContacts(frame, contacts);
	OverlayText text;
	text.title = m_subject.title;
	text.subtitle = m_subject.summary;
	text.lines = lines;
	text.footer =
		fmt::format("step {} of {}, t = {:.3f} s", moment.step, m_subject.steps, double(moment.step) * m_subject.dt);
	text.footnote = footnoteOf(m_subject, answer, contacts.size(), redMeans);
	return captioned(m_renderer->render(frame), text);
}

Image FramePainter::closeUp(const FrameMoment& moment, const FrameAnswer& answer,
							const std::vector<FrameContact>& contacts, const std::vector<std::string>& lines)
{
	Frame frame = scene(moment, answer);
	addContacts(frame, contacts);
	const SceneView& view = m_subject.closeUp;
	const Vec3 target = view.body < 0 ? view.center : toTransform(moment.poses[std::size_t(view.body)]) * view.center;
	frame.camera = orbitCamera(target, view.radius, view.azimuth, view.elevation);
	frame.ground.isDrawn = m_subject.hasGround && view.elevation > 0;
	OverlayText text;
	text.title = view.caption;
	text.lines = lines;
	text.legendTitle = "Certified error of the patches";
	text.legend = legendOf(m_subject, answer);
	text.pixelsPerMetre = frame.camera.pixelsPerMetre(kPanel);
	return captioned(m_renderer->render(frame), text);
}

Image FramePainter::paint(const FrameMoment& moment, const FrameAnswer& answer,
						  const std::vector<FrameContact>& contacts)
{
	return sideBySide({{overview(moment, answer, contacts, kCarry, figures(answer)), ""},
					   {closeUp(moment, answer, contacts, {}), ""}},
					  "");
}

Image FramePainter::paintComparison(const FrameMoment& moment, const FrameAnswer& left, const FrameAnswer& right)
{
	const auto contactsLeft = markContacts(moment, left), contactsRight = markContacts(moment, right);
	return sideBySide({{overview(moment, left, contactsLeft, kNearest, {}), "the pose"},
					   {closeUp(moment, left, contactsLeft, figures(left)), left.selection},
					   {closeUp(moment, right, contactsRight, figures(right)), right.selection}},
					  "");
}

Image FramePainter::paintExploded(const FrameMoment& moment, const FrameAnswer& all)
{
	FrameAnswer answer = all;
	answer.pairs = {pairThatShowsMost(m_subject, all)};
	Frame frame;
	frame.ground.isDrawn = false;
	const std::vector<std::set<std::uint32_t>> nodes = answeringNodes(m_subject, answer);
	std::vector<std::size_t> bodies;  // of the layers
	Vec3 low{kOff, kOff, kOff}, high = -low;
	for (std::size_t body = 0; body != nodes.size(); ++body)
	{
		if (nodes[body].empty()) continue;
		bodies.push_back(body);
		frame.patches.push_back(
			patchLayer(moment.poses[body], *m_subject.bodies[body].hierarchy, nodes[body], m_scale, body, false));
		for (const ColoredTriangle& triangle : frame.patches.back().triangles)
			for (const Vec3& corner : triangle.corners)
				for (int k = 0; k < 3; ++k)
				{
					const double at = (frame.patches.back().worldFromBody * corner)[k];
					low[k] = std::min(low[k], at);
					high[k] = std::max(high[k], at);
				}
	}
	const Vec3 middle = 0.5 * (low + high);
	const double size = 0.5 * length(high - low);
	for (std::size_t i = 0; i < bodies.size(); ++i)
	{
		PatchLayer& layer = frame.patches[i];
		const Vec3 away = kPulledApart * size * wayFromOthers(m_subject, moment, answer, bodies[i]);
		layer.worldFromBody.translation += away;
		Transform place = toTransform(moment.poses[bodies[i]]);
		place.translation += away;
		frame.instances.push_back({m_meshes[m_subject.bodies[bodies[i]].mesh], place, kGhostColor, true});
		pullPatchesApart(layer);
	}
	frame.camera = orbitCamera(middle, (1 + kSpread + kPulledApart) * size, m_subject.closeUp.azimuth, 20);
	OverlayText text;
	text.title = m_subject.title;
	text.subtitle = "the patches in contact, pulled apart";
	text.legendTitle = "Certified error of the patches";
	text.legend = legendOf(m_subject, answer);
	text.footer = fmt::format("step {} of {}", moment.step, m_subject.steps);
	text.pixelsPerMetre = frame.camera.pixelsPerMetre(kPanel);
	return captioned(m_renderer->render(frame), text);
}

// Representative contacts: closest first, each at least a spacing from those before it.
std::vector<FrameContact> FramePainter::markContacts(const FrameMoment& moment, const FrameAnswer& answer) const
{
	struct Candidate
	{
		double lower;
		FrameContact contact;
	};
	std::vector<Candidate> order;
	for (const PairAnswer& pair : answer.pairs)
	{
		const Transform worldFromA =
			worldFromBody(moment.poses[pair.bodies.a], meshFromBody(*m_subject.bodies[pair.bodies.a].hierarchy));
		for (const Contact& contact : pair.result.contacts)
			if (contact.normal != Vec3{})
				order.push_back({contact.lower, {worldFromA * contact.pointOnB, worldFromA.rotation * contact.normal}});
	}
	std::stable_sort(order.begin(), order.end(),
					 [](const Candidate& l, const Candidate& r) { return l.lower < r.lower; });
	const double spacing = kMarkerSpacing * m_subject.closeUp.radius;
	std::vector<FrameContact> marks;
	for (const Candidate& candidate : order)
	{
		const auto near = [&](const FrameContact& mark)
		{ return length(mark.position - candidate.contact.position) < spacing; };
		if (marks.size() == kLargestMarkers) break;
		if (std::none_of(marks.begin(), marks.end(), near)) marks.push_back(candidate.contact);
	}
	return marks;
}
}  // namespace clod::demo
