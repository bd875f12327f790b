// SPDX-License-Identifier: Zlib
// Pictures of two bodies in contact: shaded bodies, the patches that answered coloured by level of detail, contacts
// with normals, and a legend that explains them.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "clod/query/Query.h"
#include "demos/models/Models.h"
#include "demos/render/Renderer.h"
#include "demos/runner/HierarchyCache.h"
#include "demos/runner/Replay.h"

namespace clod::demo
{
// What never changes from frame to frame.
struct FrameSubject
{
	std::string title;
	HierarchyPointer a, b;
	ModelMesh meshA, meshB;
	Vec3 closeUp;  // centre of the close-up, frame of mesh B
	double closeUpRadius = 0.03;
	Camera overview;
	int steps = 0;
	double dt = 0;
};

// A contact to mark, in the world.
struct FrameContact
{
	Vec3 position, normal;
};

// One answer to one pose.
struct FrameAnswer
{
	std::string selection;  // e.g. "exact", "3.5 % of the radius"
	const QueryResult* result = nullptr;
	ReplayRow row;  // times and counts, with warm caches
};

class FramePainter
{
public:
	// Throws cli::Failure (1) where there is no off-screen context.
	explicit FramePainter(const FrameSubject& subject);
	// Overview and close-up beside each other.
	Image paint(const PoseRow& poses, const FrameAnswer& answer, const std::vector<FrameContact>& contacts);
	// Overview, then a close-up for each of two answers to the same pose.
	Image paintComparison(const PoseRow& poses, const FrameAnswer& left, const FrameAnswer& right);

private:
	Frame scene(const PoseRow& poses, const FrameAnswer& answer) const;
	void addContacts(Frame& frame, const std::vector<FrameContact>& contacts) const;
	void addPatches(Frame& frame, const PoseRow& poses, const QueryResult& result) const;
	Image overview(const PoseRow& poses, const FrameAnswer& answer, const std::vector<FrameContact>& contacts,
				   const std::vector<std::string>& lines);
	Image closeUp(const PoseRow& poses, const FrameAnswer& answer, const std::vector<FrameContact>& contacts,
				  const std::vector<std::string>& lines);
	int levelCount() const;

	FrameSubject m_subject;
	std::unique_ptr<Renderer> m_renderer;
	MeshId m_meshA = 0, m_meshB = 0;
};

// Representative contacts of a query: closest first, each at least `spacing` from those before it.
std::vector<FrameContact> markContacts(const PoseRow& poses, const Hierarchy& a, const QueryResult& result,
									   double spacing);
}  // namespace clod::demo
