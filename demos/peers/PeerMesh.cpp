// SPDX-License-Identifier: Zlib
// Triangles of hierarchies, of pieces in files, and how far a decimated mesh is from its original.
#include "demos/peers/PeerMesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <sstream>

#include "cli/Files.h"
#include "demos/runner/Penetration.h"

namespace clod::demo
{
namespace
{
constexpr std::size_t kPieceFileLimit = std::size_t(1) << 30;

// Finite numbers and nothing else in the rest of a line.
bool readNumbers(std::istringstream& words, double (&values)[3])
{
	for (double& value : values)
	{
		std::string word;
		if (!(words >> word)) return false;
		char* end = nullptr;
		value = std::strtod(word.c_str(), &end);
		if (end != word.c_str() + word.size() || !std::isfinite(value)) return false;
	}
	std::string rest;
	return !(words >> rest);
}

// Indices in an OBJ file count over the whole file; a piece has its own vertices.
class PieceReader
{
public:
	bool line(const std::string& text)
	{
		std::istringstream words(text);
		std::string key;
		if (!(words >> key)) return true;
		double values[3];
		if (key == "o")
		{
			m_first += m_file.pieces.empty() ? 0 : m_file.pieces.back().vertices.size();
			m_file.pieces.emplace_back();
			return true;
		}
		if (key == "#") return note(words);
		if (m_file.pieces.empty()) m_file.pieces.emplace_back();
		if (!readNumbers(words, values)) return false;
		ModelMesh& piece = m_file.pieces.back();
		if (key == "v") return piece.vertices.push_back({values[0], values[1], values[2]}), true;
		return key == "f" && face(values, piece);
	}
	PieceFile& file() { return m_file; }

private:
	bool note(std::istringstream& words)
	{
		std::string key;
		double value = 0;
		if (words >> key >> value && std::isfinite(value)) m_file.notes.emplace_back(key, value);
		return true;
	}
	bool face(const double (&values)[3], ModelMesh& piece) const
	{
		std::array<std::uint32_t, 3> triangle;
		for (std::size_t i = 0; i < 3; ++i)
		{
			const double index = values[i] - 1 - double(m_first);
			if (!(index >= 0 && index < double(piece.vertices.size())) || index != std::floor(index)) return false;
			triangle[i] = std::uint32_t(index);
		}
		piece.triangles.push_back(triangle);
		return true;
	}
	PieceFile m_file;
	std::size_t m_first = 0;  // vertices before the current piece
};

double farthest(const ModelMesh& samples, const SignedDistance& surface)
{
	double largest = 0;
	for (const Vec3& v : samples.vertices) largest = std::max(largest, std::abs(surface(v)));
	for (const auto& t : samples.triangles)
	{
		const Vec3 sum = samples.vertices[t[0]] + samples.vertices[t[1]] + samples.vertices[t[2]];
		largest = std::max(largest, std::abs(surface((1.0 / 3) * sum)));
	}
	return largest;
}
}  // namespace

double PieceFile::note(const std::string& key, double otherwise) const
{
	for (const auto& [name, value] : notes)
		if (name == key) return value;
	return otherwise;
}

Result<PieceFile> readPieces(const std::string& path)
{
	const Result<std::vector<std::byte>> bytes = cli::readFile(path, kPieceFileLimit);
	if (!bytes) return Error{bytes.error()};
	std::istringstream lines(std::string(reinterpret_cast<const char*>(bytes.value().data()), bytes.value().size()));
	PieceReader reader;
	std::size_t number = 0;
	for (std::string line; std::getline(lines, line);)
	{
		++number;
		if (!reader.line(line)) return Error{fmt::format("{}, line {}: cannot be read: {}", path, number, line)};
	}
	for (std::size_t i = 0; i < reader.file().pieces.size(); ++i)
		if (reader.file().pieces[i].vertices.empty()) return Error{fmt::format("{}: piece {} is empty", path, i)};
	if (reader.file().pieces.empty()) return Error{path + ": holds no piece"};
	return std::move(reader.file());
}

double sampledDeviation(const ModelMesh& full, const ModelMesh& coarse)
{
	return std::max(farthest(full, SignedDistance(coarse)), farthest(coarse, SignedDistance(full)));
}
}  // namespace clod::demo
