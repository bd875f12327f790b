// SPDX-License-Identifier: Zlib
#include "clod/manifold/FlushBodies.h"

#include <algorithm>

namespace clod
{
namespace
{
constexpr double kNearShare = 2e-2;   // of the length: so far beyond an edge its faces are followed
constexpr double kFlushShare = 1e-5;  // of the length: up to this bodies count as flush, so to half a milliradian

class Seam
{
public:
	Seam(const FacetQuestion& question, const JoinedBody& other, bool isOfB, const Facet& facet)
		: m_question(question),
		  m_other(other),
		  m_facet(facet),
		  m_own(isOfB ? question.b.surface(facet.levelB) : question.a.surface(facet.levelA)),
		  m_isOfB(isOfB),
		  m_near(kNearShare * question.length()),
		  m_flush(kFlushShare * question.length())
	{
	}
	bool hides(Part part) const
	{
		const std::uint32_t feature = m_isOfB ? m_facet.featureB : m_facet.featureA;
		if (part == Part::kEdge) return edgeGoesOn(feature, m_isOfB ? m_facet.ofB : m_facet.ofA);
		if (part != Part::kVertex) return false;
		const Vec3 corner = fromOwn(m_own.vertices()[feature]);
		const Span<std::uint32_t> edges = m_own.edgesOf(m_isOfB ? m_facet.nodeB : m_facet.nodeA);
		const auto leadsOn = [&](std::uint32_t e)
		{
			const std::array<std::uint32_t, 2>& ends = m_own.edges()[e].vertex;
			return (ends[0] == feature || ends[1] == feature) && edgeGoesOn(e, corner);
		};
		return std::any_of(edges.begin(), edges.end(), leadsOn);
	}

private:
	Vec3 fromOwn(const Vec3& place) const { return m_isOfB ? m_question.aFromB * place : place; }
	Vec3 inOwn(const Vec3& place) const { return m_isOfB ? inverse(m_question.aFromB) * place : place; }
	// near: what the edge is looked at next to. Not at its very end, where it may stand on the other body.
	bool edgeGoesOn(std::uint32_t e, const Vec3& near) const
	{
		const SurfaceEdge& edge = m_own.edges()[e];
		const Vec3& start = m_own.vertices()[edge.vertex[0]];
		const double end = std::min(m_near, 0.5 * edge.length);
		const double along = std::clamp(dot(inOwn(near) - start, edge.direction), end, edge.length - end);
		const Vec3 place = start + along * edge.direction;
		const double radius = m_isOfB ? m_question.rules.radiusB : m_question.rules.radiusA;
		const auto isOnOther = [&](const Vec3& normal, double beyond, const Vec3& inward)
		{ return isIn(fromOwn(place + radius * normal - beyond * inward)); };
		for (std::size_t i = 0; i < 2; ++i)
			if (isOnOther(edge.normal[i], 0, {}) && isOnOther(edge.normal[i], m_near, edge.inward[i])) return true;
		return false;
	}
	// Is a place in the other body, or of a sheet on it or, from where the body is that touches, beyond it?
	bool isIn(const Vec3& place) const
	{
		const ContactSurface& surface = *m_other.surface;
		const double scale = m_other.scale, near = 2 * scale * m_near, most = m_other.radius + m_other.rounding + scale * m_flush;
		const Vec3 there = scale * (m_other.bodyFromA * place);
		const auto heightOver = [](const SurfaceFace& face, const Vec3& p) { return dot(face.normal, p) - face.offset; };
		if (surface.isHalfSpace()) return heightOver(surface.faces()[0], there) <= most;
		if (surface.isSheet())
		{
			const PairBody& touching = m_isOfB ? m_question.rules.a : m_question.rules.b;
			const Vec3 middle = scale * (m_other.bodyFromA * touching.center);
			bool isBeyond = false;
			surface.forEachOver(there, near, [&](const SurfaceFace& face)
								{ isBeyond = isBeyond || (heightOver(face, middle) > 0 && heightOver(face, there) <= most); });
			return isBeyond;
		}
		const double reach = m_other.reach + near;
		if (surface.isCore() || lengthSquared(there - m_other.center) > reach * reach) return false;
		const ContactSurface::Nearest nearest = surface.nearest(there, std::max(most, near));
		return nearest.face == kNone ? surface.isInside(there) : nearest.distance <= most;
	}

	const FacetQuestion& m_question;
	const JoinedBody& m_other;
	const Facet& m_facet;
	const ContactSurface& m_own;
	const bool m_isOfB;
	const double m_near, m_flush;
};
}  // namespace

bool isAtSeam(const FacetQuestion& question, const JoinedBodies& joined, const Facet& facet)
{
	if (!facet.hasFeatures()) return false;
	const auto [ofA, ofB] = facet.parts();
	const auto isHidden = [&](const std::vector<JoinedBody>& others, bool isOfB, Part part)
	{
		if (others.empty() || (isOfB ? question.b.surface(facet.levelB) : question.a.surface(facet.levelA)).isCore()) return false;
		return std::any_of(others.begin(), others.end(), [&](const JoinedBody& other)
						   { return Seam(question, other, isOfB, facet).hides(part); });
	};
	return isHidden(joined.toA, false, ofA) || isHidden(joined.toB, true, ofB);
}
}  // namespace clod
