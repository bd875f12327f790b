// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/ChildProgram.h"

#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <fstream>
#include <thread>

namespace clod::test
{
pid_t startProgram(std::vector<std::string> words, const std::string& stdoutPath, const std::string& stderrPath)
{
	std::fflush(nullptr);  // or the child prints it again
	// Empty before anybody reads what an earlier child wrote there.
	for (const std::string& path : {stdoutPath, stderrPath}) std::ofstream(path, std::ios::trunc);
	const pid_t child = fork();
	if (child != 0) return child;
	std::vector<char*> raw;
	for (std::string& word : words) raw.push_back(word.data());
	raw.push_back(nullptr);
	const bool redirected = std::freopen(stdoutPath.c_str(), "w", stdout) != nullptr &&
							std::freopen(stderrPath.c_str(), "w", stderr) != nullptr;
	if (redirected) execv(raw[0], raw.data());
	_exit(127);
}

int waitForProgram(pid_t child, double seconds)
{
	const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
	int status = 0;
	bool late = false;
	while (waitpid(child, &status, late ? 0 : WNOHANG) == 0)
	{
		late = std::chrono::steady_clock::now() > end;
		if (late) kill(child, SIGKILL);
		std::this_thread::sleep_for(std::chrono::milliseconds(2));
	}
	return late ? kTimedOut : WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}
}  // namespace clod::test
