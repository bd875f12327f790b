// SPDX-License-Identifier: Zlib
#include <GL/osmesa.h>

#include "demos/render/OffscreenContext.h"

#ifdef __SANITIZE_ADDRESS__
// The leak checker's list of what is not ours: OSMesa and fontconfig (under cairo) keep some memory to the end.
extern "C" const char* __lsan_default_suppressions()
{
	return "leak:libOSMesa\nleak:libfontconfig\n";
}
#endif

namespace clod::demo
{
namespace
{
class OsMesaContext : public OffscreenContext
{
public:
	OsMesaContext(OSMesaContext context, int width, int height) : m_context(context), m_image(width, height) {}
	~OsMesaContext() override { OSMesaDestroyContext(m_context); }
	OsMesaContext(const OsMesaContext&) = delete;
	OsMesaContext& operator=(const OsMesaContext&) = delete;

	bool makeCurrent() override
	{
		if (!OSMesaMakeCurrent(m_context, m_image.rgba.data(), GL_UNSIGNED_BYTE, m_image.width, m_image.height))
			return false;
		OSMesaPixelStore(OSMESA_Y_UP, 0);
		return true;
	}

	Image pixels() override
	{
		glFinish();
		return m_image;
	}

	int width() const override { return m_image.width; }
	int height() const override { return m_image.height; }

private:
	OSMesaContext m_context;
	Image m_image;  // what OSMesa draws into
};
}  // namespace

Result<std::unique_ptr<OffscreenContext>> makeOsMesaContext(int width, int height)
{
	const int attributes[] = {OSMESA_FORMAT,
							  OSMESA_RGBA,
							  OSMESA_DEPTH_BITS,
							  24,
							  OSMESA_STENCIL_BITS,
							  8,
							  OSMESA_PROFILE,
							  OSMESA_COMPAT_PROFILE,
							  0};
	const OSMesaContext handle = OSMesaCreateContextAttribs(attributes, nullptr);
	if (!handle) return Error{"OSMesa gives no OpenGL context with 24 bits of depth and 8 of stencil."};
	std::unique_ptr<OffscreenContext> context = std::make_unique<OsMesaContext>(handle, width, height);
	if (!context->makeCurrent())
		return Error{"OSMesa cannot draw pictures of " + std::to_string(width) + " x " + std::to_string(height) + "."};
	return context;
}
}  // namespace clod::demo
