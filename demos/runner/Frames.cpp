// SPDX-License-Identifier: Zlib
// What a frame shows and says.
#include "demos/runner/Frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "demos/cli/Program.h"
#include "demos/render/Overlay.h"

namespace clod::demo
{
namespace
{
constexpr int kPanel = 720;  // pixels, each way
constexpr Color kCupColor = {0.45f, 0.62f, 0.78f, 0.22f};
constexpr Color kSpoonColor = {0.72f, 0.74f, 0.77f, 1};
constexpr Color kContactColor = {0.85f, 0.1f, 0.1f, 1};
// Arrows point from A to B: the way A pushes B.
constexpr double kMarkerSpacing = 0.004;
constexpr std::size_t kLargestMarkers = 40;
constexpr const char* kFootnote =
	"Coloured: the surface patches that answered, by level of detail. Red: contact points, and how the spoon is pushed "
	"there.";

Result<MeshId> upload(Renderer& renderer, const ModelMesh& mesh)
{
	RenderMesh render;
	render.vertices = mesh.vertices;
	render.triangles = mesh.triangles;
	return renderer.addMesh(render);
}

Transform worldFromBody(const Pose& pose, const Hierarchy& hierarchy)
{
	Transform transform = toTransform(pose);
	transform.translation = transform * meshFromBody(hierarchy);
	return transform;
}

PatchLayer patchLayer(const Pose& pose, const Hierarchy& hierarchy, const std::set<std::uint32_t>& nodes, int levels)
{
	PatchLayer layer;
	layer.worldFromBody = worldFromBody(pose, hierarchy);
	for (const std::uint32_t index : nodes)
	{
		const Node& node = hierarchy.node(index);
		const HullView hull = hierarchy.hull(node);
		const Color color = variedByIndex(levelColor(int(node.level), levels), index);
		for (const Face& face : hierarchy.faces(node))
			layer.triangles.push_back(
				{{hull.vertex(face.vertex[0]), hull.vertex(face.vertex[1]), hull.vertex(face.vertex[2])}, color});
	}
	return layer;
}

std::string millimetres(double metres)
{
	if (!std::isfinite(metres)) return "unknown";
	const double mm = 1000 * metres;
	return fmt::format(std::fabs(mm) < 0.01 ? "{:.5f} mm" : "{:.3f} mm", mm);
}

std::string gapInWords(const ReplayRow& row)
{
	if (!std::isfinite(row.minDistance)) return "not in contact";
	if (!std::isfinite(row.errorBound)) return "overlapping; the depth is not proved";
	return "gap " + millimetres(row.minDistance) + ", certified to within " + millimetres(row.errorBound);
}

std::vector<std::string> figures(const FrameAnswer& answer)
{
	const ReplayRow& row = answer.row;
	std::vector<std::string> lines;
	lines.push_back("selection: " + answer.selection);
	lines.push_back(gapInWords(row));
	lines.push_back(fmt::format("{} touching pairs of patches", row.contacts));
	lines.push_back(fmt::format("query {:.0f} µs, front of {} pairs", row.queryMicroseconds, row.stats.front));
	return lines;
}

// Levels with the largest error of either body's hierarchy.
std::vector<LegendEntry> legend(const Hierarchy& a, const Hierarchy& b, const QueryResult& result, int levels)
{
	std::set<std::uint32_t> used;
	for (const Contact& contact : result.contacts)
	{
		used.insert(a.node(contact.nodeA).level);
		used.insert(b.node(contact.nodeB).level);
	}
	std::vector<LegendEntry> entries;
	for (int level = 0; level < levels; ++level)
	{
		double deviation = 0;
		for (const Hierarchy* h : {&a, &b})
			if (level <= int(h->coarsestClodLevel()))
				deviation = std::max(deviation, double(h->levels()[std::size_t(level)].maxDeviation));
		const std::string label =
			level == 0 ? "0: full resolution" : fmt::format("{}: up to {}", level, millimetres(deviation));
		entries.push_back({levelColor(level, levels), label, used.count(std::uint32_t(level)) > 0});
	}
	return entries;
}
}  // namespace

FramePainter::FramePainter(const FrameSubject& subject) : m_subject(subject)
{
	auto renderer = Renderer::create(kPanel, kPanel);
	if (!renderer) throw cli::Failure(cli::ExitCode::failure, renderer.error());
	m_renderer = std::move(renderer.value());
	const Result<MeshId> a = upload(*m_renderer, subject.meshA), b = upload(*m_renderer, subject.meshB);
	if (!a || !b) throw cli::Failure(cli::ExitCode::failure, a ? b.error() : a.error());
	m_meshA = a.value();
	m_meshB = b.value();
}

int FramePainter::levelCount() const
{
	return int(std::max(m_subject.a->coarsestClodLevel(), m_subject.b->coarsestClodLevel())) + 1;
}

void FramePainter::addPatches(Frame& frame, const PoseRow& poses, const QueryResult& result) const
{
	std::set<std::uint32_t> nodesA, nodesB;
	for (const Contact& contact : result.contacts)
	{
		nodesA.insert(contact.nodeA);
		nodesB.insert(contact.nodeB);
	}
	frame.patches.push_back(patchLayer(poses.a, *m_subject.a, nodesA, levelCount()));
	frame.patches.push_back(patchLayer(poses.b, *m_subject.b, nodesB, levelCount()));
}

void FramePainter::addContacts(Frame& frame, const std::vector<FrameContact>& contacts) const
{
	const double size = m_subject.closeUpRadius;
	for (const FrameContact& contact : contacts)
	{
		frame.markers.push_back({contact.position, 0.016 * size, kContactColor});
		frame.arrows.push_back(
			{contact.position, contact.position - (0.25 * size) * contact.normal, 0.007 * size, kContactColor});
	}
}

Frame FramePainter::scene(const PoseRow& poses, const FrameAnswer& answer) const
{
	Frame frame;
	frame.camera = m_subject.overview;
	frame.instances.push_back({m_meshA, toTransform(poses.a), kCupColor, true});
	frame.instances.push_back({m_meshB, toTransform(poses.b), kSpoonColor, false});
	addPatches(frame, poses, *answer.result);
	return frame;
}

Image FramePainter::overview(const PoseRow& poses, const FrameAnswer& answer, const std::vector<FrameContact>& contacts,
							 const std::vector<std::string>& lines)
{
	Frame frame = scene(poses, answer);
	addContacts(frame, contacts);
	Image image = m_renderer->render(frame);
	OverlayText text;
	text.title = m_subject.title;
	text.subtitle = "the whole scene";
	text.lines = lines;
	text.footer =
		fmt::format("step {} of {}, t = {:.3f} s", poses.step, m_subject.steps, double(poses.step) * m_subject.dt);
	text.footnote = kFootnote;
	drawOverlay(image, text);
	return image;
}

Image FramePainter::closeUp(const PoseRow& poses, const FrameAnswer& answer, const std::vector<FrameContact>& contacts,
							const std::vector<std::string>& lines)
{
	Frame frame = scene(poses, answer);
	addContacts(frame, contacts);
	// From below, through the see-through body: the patches that touch are on the underside.
	const Vec3 target = toTransform(poses.b) * m_subject.closeUp;
	frame.camera = orbitCamera(target, m_subject.closeUpRadius, 25, -30);
	frame.ground.isDrawn = false;
	Image image = m_renderer->render(frame);
	OverlayText text;
	text.title = "close-up from below, through the cup";
	text.lines = lines;
	text.legendTitle = "Level of detail and its error";
	text.legend = legend(*m_subject.a, *m_subject.b, *answer.result, levelCount());
	text.pixelsPerMetre = frame.camera.pixelsPerMetre(kPanel);
	drawOverlay(image, text);
	return image;
}

Image FramePainter::paint(const PoseRow& poses, const FrameAnswer& answer, const std::vector<FrameContact>& contacts)
{
	return sideBySide(
		{{overview(poses, answer, contacts, figures(answer)), ""}, {closeUp(poses, answer, contacts, {}), ""}}, "");
}

Image FramePainter::paintComparison(const PoseRow& poses, const FrameAnswer& left, const FrameAnswer& right)
{
	const auto contactsLeft = markContacts(poses, *m_subject.a, *left.result, kMarkerSpacing);
	const auto contactsRight = markContacts(poses, *m_subject.a, *right.result, kMarkerSpacing);
	return sideBySide({{overview(poses, left, contactsLeft, {}), "the pose"},
					   {closeUp(poses, left, contactsLeft, figures(left)), left.selection},
					   {closeUp(poses, right, contactsRight, figures(right)), right.selection}},
					  "");
}

std::vector<FrameContact> markContacts(const PoseRow& poses, const Hierarchy& a, const QueryResult& result,
									   double spacing)
{
	std::vector<const Contact*> order;
	for (const Contact& contact : result.contacts)
		if (contact.normal != Vec3{}) order.push_back(&contact);
	std::stable_sort(order.begin(), order.end(),
					 [](const Contact* l, const Contact* r) { return l->lower < r->lower; });
	const Transform worldFromA = worldFromBody(poses.a, a);
	std::vector<FrameContact> marks;
	for (const Contact* contact : order)
	{
		const Vec3 position = worldFromA * contact->pointOnB;
		const auto near = [&](const FrameContact& mark) { return length(mark.position - position) < spacing; };
		if (marks.size() == kLargestMarkers) break;
		if (std::none_of(marks.begin(), marks.end(), near))
			marks.push_back({position, worldFromA.rotation * contact->normal});
	}
	return marks;
}
}  // namespace clod::demo
