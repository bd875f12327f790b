// SPDX-License-Identifier: Zlib
// Pictures of bodies in contact: shaded bodies, the patches that answered coloured by their certified error, contacts
// with normals, and a legend that explains them.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "clod/query/Query.h"
#include "demos/models/Models.h"
#include "demos/render/Overlay.h"
#include "demos/render/Renderer.h"
#include "demos/runner/HierarchyCache.h"
#include "demos/runner/Replay.h"
#include "demos/scenes/Scene.h"

namespace clod::demo
{
struct FrameBody
{
	std::size_t mesh;  // in FrameSubject::meshes
	HierarchyPointer hierarchy;
	bool isSeenThrough;
};

// What never changes from frame to frame.
struct FrameSubject
{
	std::string title, summary;
	std::vector<ModelMesh> meshes;
	std::vector<FrameBody> bodies;
	SceneView closeUp;
	Camera overview, overviewAtEnd;  // at the first and the last step; evenly between
	bool hasGround = true;
	int steps = 0;
	double dt = 0;
	double largestError = kOff;  // of all patches that its pictures show: where colours end; kOff: of all levels
};

Camera overviewCamera(const SceneView& view);

// Where everything is.
struct FrameMoment
{
	std::int64_t step = 0;
	std::vector<Pose> poses;  // of meshes, one a body
};

// A contact to mark, in the world.
struct FrameContact
{
	Vec3 position, normal;
};

// The answers to one moment.
struct FrameAnswer
{
	std::string selection;  // e.g. "exact", "3.5 % of the radius"
	std::vector<PairAnswer> pairs;
	ReplayRow row;  // times and counts of all pairs, with warm caches
};

// Colours of certified errors, the same for all bodies of a subject and all its pictures: two steps a decade (up to 1,
// up to 3, up to 10, ...), from what is exact to the eye up to the largest error shown.
class ErrorScale
{
public:
	explicit ErrorScale(const FrameSubject& subject);
	int steps() const { return m_steps; }
	int stepOf(double error) const;
	double largestOf(int step) const;
	Color color(int step) const { return levelColor(step, m_steps); }

private:
	int m_first = 0;  // half decades of the first step
	int m_steps = 1;
};

// Of the errors that are in the picture, smallest first.
std::vector<LegendEntry> legendOf(const FrameSubject& subject, const FrameAnswer& answer);

// What the colours mean that are in the picture, with so many contacts marked in red.
std::string footnoteOf(const FrameSubject& subject, const FrameAnswer& answer, std::size_t contacts,
					   const std::string& redMeans);

// Of the patches that its pictures colour: the largest certified error, and how many there are.
double largestErrorShown(const FrameSubject& subject, const FrameAnswer& answer);
std::size_t patchesShown(const FrameSubject& subject, const FrameAnswer& answer);

// The pair of which most patches are coloured: one with both bodies', where there is any. A digit on a floor, which is
// one patch, has no other side.
const PairAnswer& pairThatShowsMost(const FrameSubject& subject, const FrameAnswer& answer);

class FramePainter
{
public:
	// Throws cli::Failure (1) where there is no off-screen context.
	explicit FramePainter(const FrameSubject& subject);
	// Overview and close-up beside each other.
	Image paint(const FrameMoment& moment, const FrameAnswer& answer, const std::vector<FrameContact>& contacts);
	// Overview, then a close-up for each of two answers to the same moment.
	Image paintComparison(const FrameMoment& moment, const FrameAnswer& left, const FrameAnswer& right);
	// The patches in contact alone, of the pair that shows most (one body at least has some): the two sides pulled
	// apart along the contacts, the patches of a side from each other.
	Image paintExploded(const FrameMoment& moment, const FrameAnswer& answer);

private:
	Frame scene(const FrameMoment& moment, const FrameAnswer& answer) const;
	void addContacts(Frame& frame, const std::vector<FrameContact>& contacts) const;
	void addPatches(Frame& frame, const FrameMoment& moment, const FrameAnswer& answer) const;
	std::vector<FrameContact> markContacts(const FrameMoment& moment, const FrameAnswer& answer) const;
	Image overview(const FrameMoment& moment, const FrameAnswer& answer, const std::vector<FrameContact>& contacts,
				   const std::string& redMeans, const std::vector<std::string>& lines);
	Image closeUp(const FrameMoment& moment, const FrameAnswer& answer, const std::vector<FrameContact>& contacts,
				  const std::vector<std::string>& lines);

	FrameSubject m_subject;
	ErrorScale m_scale;
	std::unique_ptr<Renderer> m_renderer;
	std::vector<MeshId> m_meshes;
};
}  // namespace clod::demo
