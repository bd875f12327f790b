// SPDX-License-Identifier: GPL-3.0-or-later
// A consumer of the builder: a mesh file to a hierarchy in memory, its progress told.
#include <clod/builder/Builder.h>

#include <cstdio>

int main(int, char** arguments)
{
	int calls = 0;
	const auto built =
		clod::builder::buildFile(arguments[1], {}, [&calls](const char*, double) { return ++calls > 0; });
	if (built.status != clod::builder::Status::built) return std::puts(built.message.c_str()), 1;
	const clod::Asset& asset = built.hierarchy->asset();
	std::printf("built: %zu bytes, volume %g, centre of mass %g %g %g, %d calls\n", built.hierarchy->bytes().size(),
				asset.volume, asset.meshFromBody[0], asset.meshFromBody[1], asset.meshFromBody[2], calls);
	return asset.volume > 0 && calls > 0 ? 0 : 1;
}
