// SPDX-License-Identifier: Zlib
// Eigenvectors of a symmetric matrix, as of inertia, and a rotation as a quaternion.
#pragma once
#include <array>

#include "clod/Export.h"
#include "clod/collide/Vector.h"

namespace clod
{
// Eigenvalues ascending, eigenvectors as rows of a right-handed frame (cyclic Jacobi).
struct EigenFrame
{
	std::array<double, 3> values{};
	Mat3 axes;
};
CLOD_API EigenFrame eigenFrame(const std::array<double, 6>& symmetric);  // xx, yy, zz, xy, xz, yz

// x, y, z, w of the rotation that takes the axes of coordinates to the rows (Shepperd's method).
CLOD_API std::array<double, 4> quaternionOf(const Mat3& rows);
}  // namespace clod
