// SPDX-License-Identifier: Zlib
// Starting other programs and waiting for them.
#include "demos/runner/Process.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>

#include "cli/Program.h"

namespace clod::demo
{
namespace
{
// Replaces this process by another program; only async-signal-safe calls. Should its parent die, it is told.
[[noreturn]] void become(const char* program, char* const* arguments, bool quiet)
{
	prctl(PR_SET_PDEATHSIG, SIGTERM);
	const int nowhere = quiet ? open("/dev/null", O_WRONLY) : -1;
	dup2(nowhere >= 0 ? nowhere : STDERR_FILENO, STDOUT_FILENO);  // our stdout is for our own results
	execvp(program, arguments);
	_exit(kProgramMissing);
}

int waitFor(pid_t child)
{
	int status = 0;
	while (waitpid(child, &status, 0) < 0)
		if (errno != EINTR) return -1;
	return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}
}  // namespace

int runProgram(const std::vector<std::string>& words, bool quiet)
{
	std::vector<char*> arguments;
	for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
	arguments.push_back(nullptr);
	const pid_t child = fork();
	if (child < 0)
		throw cli::Failure(cli::ExitCode::failure, fmt::format("cannot start {}: {}", words[0], std::strerror(errno)));
	if (child == 0) become(arguments[0], arguments.data(), quiet);
	return waitFor(child);
}
}  // namespace clod::demo
