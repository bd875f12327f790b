// SPDX-License-Identifier: GPL-3.0-or-later
#include "builder/repair/Wrap.h"

#include <CGAL/alpha_wrap_3.h>

#include <algorithm>

#include "builder/repair/SurfaceMesh.h"

namespace clod::builder
{
namespace
{
struct TooMany
{
};

class Vertices : public CGAL::Alpha_wraps_3::internal::Wrapping_default_visitor
{
public:
	Vertices(const WrapSize& size, const Progress& progress) : m_size(size), m_progress(progress) {}
	template <class Wrapper, class VertexHandle>
	void after_Steiner_point_insertion(const Wrapper&, VertexHandle)
	{
		if (double(++m_inserted) > m_size.most) throw TooMany();
		if (m_inserted % 256 == 0) report(m_progress, "wrap", std::min(double(m_inserted) / m_size.expected, 1.0));
	}

private:
	std::size_t m_inserted = 0;
	const WrapSize m_size;
	const Progress& m_progress;
};
}  // namespace

std::optional<Mesh> alphaWrap(const Mesh& mesh, double alpha, double offset, const WrapSize& size,
							  const Progress& progress)
{
	std::vector<Point> points;
	for (const Vec3& v : mesh.vertices) points.push_back(toPoint(v));
	SurfaceMesh wrap;
	try
	{
		CGAL::alpha_wrap_3(points, mesh.triangles, alpha, offset, wrap, CGAL::parameters::default_values(),
						   CGAL::parameters::visitor(Vertices(size, progress)));
	}
	catch (const TooMany&)
	{
		return {};
	}
	return toMesh(wrap);
}
}  // namespace clod::builder
