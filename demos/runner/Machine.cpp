// SPDX-License-Identifier: Zlib
// The machine line of a report. Compiled once per Bullet precision, which it names.
#include <nlohmann/json.hpp>
#include <LinearMath/btScalar.h>

#include <algorithm>
#include <fstream>
#include <thread>

#include "cli/Version.h"
#include "demos/runner/Statistics.h"

namespace clod::demo
{
namespace
{
std::string firstLine(const std::string& path)
{
	std::ifstream file(path);
	std::string line;
	std::getline(file, line);
	return line.empty() ? "unknown" : line;
}

std::string processor()
{
	std::ifstream file("/proc/cpuinfo");
	for (std::string line; std::getline(file, line);)
		if (line.rfind("model name", 0) == 0) return line.substr(std::min(line.size(), line.find(':') + 2));
	return "unknown";
}
}  // namespace

bool hasDoublePrecision()
{
	return sizeof(btScalar) == 8;
}

nlohmann::ordered_json machine()
{
	return {{"processor", processor()},
			{"cores", std::thread::hardware_concurrency()},
			{"governor", firstLine("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor")},
			{"compiler", cli::compilerName()},
#ifdef NDEBUG
			{"assertions", false},
#else
			{"assertions", true},
#endif
			{"bullet", btGetVersion()},
			{"precision", hasDoublePrecision() ? "float64" : "float32"},
			{"commit", cli::gitHash()}};
}
}  // namespace clod::demo
