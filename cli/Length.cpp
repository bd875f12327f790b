// SPDX-License-Identifier: Zlib
#include "cli/Length.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <charconv>
#include <cmath>

namespace clod::cli
{
namespace
{
struct Unit
{
	const char* name;
	double factor;
	bool shareOfRadius;
};
constexpr Unit kUnits[] = {{"", 1, false},      {"um", 1e-6, false}, {"mm", 1e-3, false},
						   {"cm", 1e-2, false}, {"m", 1, false},     {"%", 1e-2, true}};
}  // namespace

Result<Length> parseLength(const std::string& text)
{
	double number = 0;
	const char* const end = text.data() + text.size();
	const auto parsed = std::from_chars(text.data(), end, number);
	if (parsed.ec != std::errc() || !std::isfinite(number))
		return Error{fmt::format("'{}' is not a length; write 0.5mm, 0.0005 or 1%", text)};
	if (number < 0) return Error{fmt::format("length '{}' is negative", text)};
	const std::string suffix(parsed.ptr, end);
	for (const Unit& unit : kUnits)
		if (suffix == unit.name)
		{
			// Dividing by an exact power of ten rounds once: 0.5mm is the double nearest to 0.0005.
			const double value = unit.factor < 1 ? number / std::round(1 / unit.factor) : number;
			return Length{value, unit.shareOfRadius, text};
		}
	return Error{fmt::format("'{}' has the unknown unit '{}'; use um, mm, cm, m or %", text, suffix)};
}

std::string describe(const Length& length, double radius, const std::function<std::string(double)>& inWords)
{
	const auto said = [&](double value) { return inWords ? inWords(value) : fmt::format("{:.4g}", value); };
	if (length.shareOfRadius)
		return fmt::format("{} ({} of the radius of {})", said(length.inMeshUnit(radius)), length.text, said(radius));
	const std::string value = said(length.value);
	return fmt::format("{}{} ({:.3g} % of the radius of {})", length.text, value == length.text ? "" : " = " + value,
					   radius > 0 ? 100 * length.value / radius : 0, said(radius));
}

std::string mendingAfter(bool repair, const std::optional<Length>& wrap)
{
	constexpr double kCoarser = 2.5;
	if (wrap && wrap->shareOfRadius) return fmt::format("--wrap {:.3g}%", 100 * kCoarser * wrap->value);
	if (wrap) return fmt::format("--wrap {:.3g}", kCoarser * wrap->value);
	return repair ? "--wrap 2%" : "--repair";
}

CLI::Option* addLength(CLI::App& command, const std::string& name, std::optional<Length>& value,
					   const std::string& description)
{
	const auto check = [](std::string& text) -> std::string
	{
		const Result<Length> length = parseLength(text);
		return length ? std::string() : length.error();
	};
	const auto store = [&value](const std::string& text) { value = parseLength(text).value(); };
	return command.add_option_function<std::string>(name, store, description)
		->check(CLI::Validator(check, "", "length"))
		->type_name("LEN");
}
}  // namespace clod::cli
