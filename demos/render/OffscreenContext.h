// SPDX-License-Identifier: Zlib
// An OpenGL context that draws into memory, without window or display. One implementation: OSMesa (software). Another
// one, say EGL, needs only this interface; the renderer uses plain OpenGL 2.1 calls between makeCurrent and pixels.
#pragma once
#include <memory>

#include "demos/render/Image.h"

namespace clod::demo
{
class OffscreenContext
{
public:
	virtual ~OffscreenContext() = default;
	virtual bool makeCurrent() = 0;
	virtual Image pixels() = 0;  // what has been drawn, rows from the top
	virtual int width() const = 0;
	virtual int height() const = 0;
};

// With depth and stencil.
Result<std::unique_ptr<OffscreenContext>> makeOsMesaContext(int width, int height);
}  // namespace clod::demo
