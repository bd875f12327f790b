// SPDX-License-Identifier: Zlib
#include "cli/Program.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <csignal>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <new>

#include "cli/Files.h"
#include "cli/Suggestion.h"
#include "cli/Version.h"

namespace clod::cli
{
namespace
{
// Only async-signal-safe calls here.
extern "C" void onInterrupt(int)
{
	removePartialFiles();
	constexpr char text[] = "\ninterrupted\n";
	[[maybe_unused]] const auto written = write(STDERR_FILENO, text, sizeof(text) - 1);
	_exit(int(ExitCode::interrupted));
}

void catchInterrupts()
{
	struct sigaction action = {};
	action.sa_handler = onInterrupt;
	sigemptyset(&action.sa_mask);
	for (const int signal : {SIGINT, SIGTERM, SIGXCPU}) sigaction(signal, &action, nullptr);
	for (const int signal : {SIGHUP, SIGQUIT})  // which nohup, or a shell that runs it in the background, has it ignore
		if (struct sigaction was = {}; sigaction(signal, nullptr, &was) == 0 && was.sa_handler != SIG_IGN)
			sigaction(signal, &action, nullptr);
	std::signal(SIGXFSZ, SIG_IGN);  // a file that may not grow cannot be written, as on a full disk
}

// The innermost subcommand the user chose.
const CLI::App& chosen(const CLI::App& app)
{
	const auto subcommands = app.get_subcommands();
	return subcommands.empty() ? app : chosen(*subcommands.front());
}

std::vector<std::string> optionNames(const CLI::App& command)
{
	std::vector<std::string> names;
	for (const CLI::Option* option : command.get_options())
		for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
	return names;
}

std::vector<std::string> commandNames(const CLI::App& command)
{
	std::vector<std::string> names;
	for (const CLI::App* subcommand : command.get_subcommands([](const CLI::App*) { return true; }))
		names.push_back(subcommand->get_name());
	return names;
}

// What to say about a command line that cannot be parsed: the first word nobody understood, else CLI11's own sentence.
std::string explain(const CLI::App& app, const CLI::ParseError& error)
{
	const CLI::App& command = chosen(app);
	for (std::string word : app.remaining(true))
	{
		if (word == "--") continue;
		if (word.size() > 1 && word[0] == '-')
		{
			word = word.substr(0, word.find('='));
			return fmt::format("unknown option {}{}", word, didYouMean(word, optionNames(command)));
		}
		const std::vector<std::string> commands = commandNames(command);
		if (!commands.empty()) return fmt::format("unknown command '{}'{}", word, didYouMean(word, commands));
		return fmt::format("unexpected argument '{}'", word);
	}
	return error.what();
}

int reportParseError(const CLI::App& app, const CLI::ParseError& error)
{
	const std::string path = &chosen(app) == &app ? app.get_name() : app.get_name() + " " + chosen(app).get_name();
	fmt::print(stderr, "{}: {}\nTry '{} --help'.\n", path, explain(app, error), path);
	return int(ExitCode::usage);
}

int fail(const CLI::App& app, ExitCode code, const std::string& message)
{
	fmt::print(stderr, "{}: {}\n", app.get_name(), message);
	return int(code);
}

// However it is named, and whether it exists yet or not. A device may take several results.
bool isSameFile(const std::string& one, const std::string& other)
{
	if (one.empty() || other.empty() || one == "-" || other == "-") return false;
	std::error_code error;
	const auto whole = [&error](const std::string& name)
	{ return std::filesystem::weakly_canonical(std::filesystem::absolute(name, error), error); };
	const std::filesystem::path path = whole(one);
	if (path.empty() || path != whole(other)) return false;
	return !std::filesystem::exists(path, error) || std::filesystem::is_regular_file(path, error);
}
}  // namespace

void addQuiet(CLI::App& command, CommonOptions& options)
{
	command.add_flag("--quiet", options.quiet, "No progress on stderr, only errors");
}

void addJson(CLI::App& command, CommonOptions& options)
{
	command.add_option("--json", options.json, "Write a machine-readable report to FILE; - is stdout")
		->type_name("FILE");
}

void addSeed(CLI::App& command, CommonOptions& options, const std::string& description)
{
	const auto check = [](std::string& text) -> std::string
	{
		std::uint64_t seed = 0;
		const char* const end = text.data() + text.size();
		const auto parsed = std::from_chars(text.data(), end, seed);
		const bool isWhole = parsed.ec == std::errc() && parsed.ptr == end;
		return isWhole ? std::string() : fmt::format("'{}' is not a whole number from 0 to 2^64 - 1", text);
	};
	command.add_option("--seed", options.seed, description)
		->check(CLI::Validator(check, "", "seed"))
		->type_name("N")
		->capture_default_str();
}

void addThreads(CLI::App& command, CommonOptions& options)
{
	command.add_option("--threads", options.threads, "Threads; 0 = all cores. The result is the same for every N")
		->type_name("N")
		->check(CLI::Range(0u, 1024u))
		->capture_default_str();
}

void addOutput(CLI::App& command, std::string& path, const std::string& type, const std::string& description)
{
	const auto check = [](const std::string& name)
	{ return name.empty() ? std::string("the name to write to is empty") : std::string(); };
	command.add_option("-o,--output", path, description)
		->required()
		->type_name(type)
		->check(CLI::Validator(check, "", "name"));
}

void addFolder(CLI::App& command, std::string& folder, const std::string& files)
{
	addOutput(command, folder, "DIR", "Folder for " + files);
}

void requireWritable(std::initializer_list<std::string> files, const std::vector<std::string>& inputs)
{
	if (std::count(files.begin(), files.end(), "-") > 1)
		throw Failure(ExitCode::usage, "two results are to go to stdout (-); name a file for one of them");
	for (auto file = files.begin(); file != files.end(); ++file)
	{
		for (const std::string& input : inputs)
			if (isSameFile(*file, input) && std::filesystem::exists(input))
				throw Failure(ExitCode::usage, *file + " is read; name another file to write to");
		for (auto other = files.begin(); other != file; ++other)
			if (isSameFile(*file, *other)) throw Failure(ExitCode::usage, "two results are to go to " + *file);
	}
	for (const std::string& file : files)
	{
		const std::string problem = file.empty() ? std::string() : unwritable(file);
		if (!problem.empty()) throw Failure(ExitCode::failure, problem);
	}
}

CLI::Validator oneOf(const std::vector<std::string>& choices)
{
	const auto check = [choices](std::string& word) -> std::string
	{
		for (const std::string& choice : choices)
			if (word == choice) return {};
		return fmt::format("'{}' is not one of {}{}", word, fmt::join(choices, ", "), didYouMean(word, choices));
	};
	return CLI::Validator(check, fmt::format("{}", fmt::join(choices, "|")), "choice");
}

CLI::Option* addChoice(CLI::App& command, const std::string& name, std::string& value,
					   const std::vector<std::string>& choices, const std::string& description)
{
	return command.add_option(name, value, description)->check(oneOf(choices))->capture_default_str();
}

void setUpProgram(CLI::App& app, const std::string& precision, const std::string& licence)
{
	app.set_version_flag("--version", versionText(app.get_name(), precision, licence));
	app.require_subcommand(1);
	app.fallthrough(false);
}

int runProgram(CLI::App& app, int argc, char** argv)
{
	catchInterrupts();
	try
	{
		app.parse(argc, argv);
		return int(ExitCode::ok);
	}
	catch (const CLI::CallForVersion&)
	{
		fmt::print("{}\n", app.version());
		return int(ExitCode::ok);
	}
	catch (const CLI::Success& help)
	{
		return app.exit(help);
	}
	catch (const CLI::ParseError& error)
	{
		return reportParseError(app, error);
	}
	catch (const Failure& failure)
	{
		return fail(app, failure.code(), failure.what());
	}
	catch (const std::bad_alloc&)
	{
		return fail(app, ExitCode::limitReached, "out of memory");
	}
	catch (const std::exception& error)
	{
		return fail(app, ExitCode::failure, error.what());
	}
}
}  // namespace clod::cli
