// SPDX-License-Identifier: GPL-3.0-or-later
// A consumer of the builder: a mesh file to a hierarchy in memory, its progress told; then cancelled, failing in the
// callback, and given what is no mesh. Nothing is caught here, as nothing is thrown.
#include <clod/builder/Builder.h>

#include <cstdio>
#include <stdexcept>

using clod::builder::buildFile;
using clod::builder::Status;

int main(int, char** arguments)
{
	int calls = 0;
	const auto built = buildFile(arguments[1], {}, [&calls](const char*, double) { return ++calls > 0; });
	if (built.status != Status::built) return std::puts(built.message.c_str()), 1;
	const clod::Asset& asset = built.hierarchy->asset();
	std::printf("built: %zu bytes, volume %g, inertia %g, centre of mass %g %g %g, %d calls\n",
				built.hierarchy->bytes().size(), asset.volume, asset.inertia[0], asset.meshFromBody[0],
				asset.meshFromBody[1], asset.meshFromBody[2], calls);
	const bool fills = asset.volume > 0 && asset.inertia[0] > 0 && asset.meshFromBody[0] != 0 && calls > 0;

	const auto cancelled = buildFile(arguments[1], {}, [](const char*, double) { return false; });
	const auto thrown = [](const char*, double) -> bool { throw std::runtime_error("of the callback"); };
	const auto failed = buildFile(arguments[1], {}, thrown);
	const auto refused = buildFile(arguments[0]);  // this program
	std::printf("%s; %s; %s\n", cancelled.message.c_str(), failed.message.c_str(), refused.message.c_str());
	const bool tells = cancelled.status == Status::cancelled && refused.status == Status::refused &&
					   failed.status == Status::failed && failed.message == "of the callback";
	return fills && tells ? 0 : 1;
}
