// SPDX-License-Identifier: GPL-3.0-or-later
// Stanford PLY 1.0: ASCII and binary of either endianness; any elements and properties, of which only the vertices'
// x y z and the faces' vertex_indices (or vertex_index) are kept.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <optional>

#include "builder/intake/ReadMesh.h"
#include "builder/intake/TextCursor.h"

namespace clod::builder
{
namespace
{
enum class Type
{
	int8,
	uint8,
	int16,
	uint16,
	int32,
	uint32,
	float32,
	float64
};
constexpr std::array<std::size_t, 8> kSize = {1, 1, 2, 2, 4, 4, 4, 8};
enum class Format
{
	ascii,
	littleEndian,
	bigEndian
};

struct Property
{
	std::string name;
	Type type = Type::float32;
	std::optional<Type> listCount;  // type of the count in front of a list
};
struct Element
{
	std::string name;
	std::size_t count = 0;
	std::vector<Property> properties;
};
struct Header
{
	Format format = Format::ascii;
	std::vector<Element> elements;
};

Type typeNamed(const TextCursor& cursor, std::string_view word)
{
	constexpr std::array<std::string_view, 8> kShort = {"char", "uchar", "short", "ushort",
														"int",  "uint",  "float", "double"};
	constexpr std::array<std::string_view, 8> kLong = {"int8",  "uint8",  "int16",   "uint16",
													   "int32", "uint32", "float32", "float64"};
	for (std::size_t i = 0; i < kShort.size(); ++i)
		if (word == kShort[i] || word == kLong[i]) return Type(i);
	cursor.refuse(fmt::format("'{}' is not a PLY type", word.substr(0, 40)));
}

Format formatNamed(TextCursor& cursor)
{
	const std::string_view word = cursor.word();
	if (cursor.word() != "1.0") cursor.refuse("only PLY version 1.0 is known");
	if (word == "ascii") return Format::ascii;
	if (word == "binary_little_endian") return Format::littleEndian;
	if (word == "binary_big_endian") return Format::bigEndian;
	cursor.refuse(fmt::format("'{}' is not a PLY format", word.substr(0, 40)));
}

Property readProperty(TextCursor& cursor)
{
	Property property;
	std::string_view word = cursor.word();
	if (word == "list")
	{
		property.listCount = typeNamed(cursor, cursor.word());
		if (*property.listCount >= Type::float32) cursor.refuse("the count of a list is not an integer type");
		word = cursor.word();
	}
	property.type = typeNamed(cursor, word);
	property.name = cursor.word();
	return property;
}

Header readHeader(TextCursor& cursor)
{
	if (!cursor.nextLine() || cursor.word() != "ply") cursor.refuse("a PLY file starts with 'ply'");
	Header header;
	bool formatSeen = false;
	while (cursor.nextLine())
	{
		const std::string_view keyword = cursor.word();
		if (keyword == "end_header")
		{
			if (!formatSeen) cursor.refuse("the header names no format");
			return header;
		}
		if (keyword == "format")
		{
			header.format = formatNamed(cursor);
			formatSeen = true;
		}
		else if (keyword == "element")
		{
			Element element;
			element.name = cursor.word();
			const long long count = cursor.integer(cursor.word());
			if (count < 0) cursor.refuse(fmt::format("element '{}' has the count {}", element.name, count));
			element.count = std::size_t(count);
			header.elements.push_back(element);
		}
		else if (keyword == "property" && !header.elements.empty())
			header.elements.back().properties.push_back(readProperty(cursor));
		else if (keyword != "comment" && keyword != "obj_info" && !keyword.empty())
			cursor.refuse(fmt::format("unknown header line '{}'", keyword.substr(0, 40)));
	}
	cursor.refuse("the header does not end");
}

// The values of the body one after the other, whatever the format.
class Values
{
public:
	Values(Format format, TextCursor cursor, std::size_t size)
		: m_format(format), m_text(cursor), m_bytes(cursor.rest()), m_size(size)
	{
	}
	double next(Type type) { return m_format == Format::ascii ? nextWord(type) : nextBinary(type); }
	// Refuses unless `count` values of at least `bytes` each can be left.
	void reserve(std::size_t count, std::size_t bytes, const std::string& what) const
	{
		const std::size_t left = m_format == Format::ascii ? m_text.rest().size() + m_size : m_bytes.size();
		if (count > left / std::max<std::size_t>(m_format == Format::ascii ? 1 : bytes, 1))
			throw Refused(Reason::syntax, fmt::format("the file is too short for {} {}", count, what));
	}
	std::string place() const
	{
		return m_format == Format::ascii ? m_text.place() : fmt::format("byte {}", m_size - m_bytes.size());
	}

private:
	double nextWord(Type type)
	{
		const std::string_view word = m_text.wordAnywhere();
		if (word.empty()) m_text.refuse("the file ends inside its data");
		return type >= Type::float32 ? m_text.number(word) : double(m_text.integer(word));
	}
	double nextBinary(Type type)
	{
		const std::size_t size = kSize[std::size_t(type)];
		if (m_bytes.size() < size) throw Refused(Reason::syntax, place() + ": the file ends inside its data");
		std::array<char, 8> raw = {};
		std::copy_n(m_bytes.data(), size, raw.begin());
		m_bytes.remove_prefix(size);
		if (m_format == Format::bigEndian) std::reverse(raw.begin(), raw.begin() + std::ptrdiff_t(size));
		return decoded(type, raw);
	}
	template <class T>
	static double as(const std::array<char, 8>& raw)
	{
		T value;
		std::memcpy(&value, raw.data(), sizeof(T));
		return double(value);
	}
	static double decoded(Type type, const std::array<char, 8>& raw)
	{
		switch (type)
		{
			case Type::int8:
				return as<std::int8_t>(raw);
			case Type::uint8:
				return as<std::uint8_t>(raw);
			case Type::int16:
				return as<std::int16_t>(raw);
			case Type::uint16:
				return as<std::uint16_t>(raw);
			case Type::int32:
				return as<std::int32_t>(raw);
			case Type::uint32:
				return as<std::uint32_t>(raw);
			case Type::float32:
				return as<float>(raw);
			case Type::float64:
				return as<double>(raw);
		}
		return 0;
	}

	Format m_format;
	TextCursor m_text;
	std::string_view m_bytes;
	std::size_t m_size;
};

std::size_t readListCount(Values& values, const Property& property)
{
	const double count = values.next(*property.listCount);
	if (count < 0) throw Refused(Reason::syntax, fmt::format("{}: a list has the count {}", values.place(), count));
	values.reserve(std::size_t(count), kSize[std::size_t(property.type)], "list entries");
	return std::size_t(count);
}

void readVertex(Values& values, const Element& element, Soup& soup)
{
	Vec3 v;
	for (const Property& property : element.properties)
	{
		const std::size_t count = property.listCount ? readListCount(values, property) : 1;
		for (std::size_t i = 0; i < count; ++i)
		{
			const double value = values.next(property.type);
			if (property.name == "x") v.x = value;
			if (property.name == "y") v.y = value;
			if (property.name == "z") v.z = value;
		}
	}
	soup.vertices.push_back(v);
}

bool isCornerList(const Property& property)
{
	return property.listCount && (property.name == "vertex_indices" || property.name == "vertex_index");
}

void readFace(Values& values, const Element& element, std::size_t index, Soup& soup)
{
	for (const Property& property : element.properties)
	{
		const std::size_t count = property.listCount ? readListCount(values, property) : 1;
		const bool corners = isCornerList(property);
		if (corners && count < 3)
			throw Refused(Reason::syntax, fmt::format("{}: face {} has {} corners", values.place(), index, count));
		for (std::size_t i = 0; i < count; ++i)
		{
			const double value = values.next(property.type);
			if (corners) soup.corners.push_back(checkedIndex((long long)(value), values.place()));
		}
	}
	soup.endPolygon();
}

// Only what the readers above rely on.
void checkProperties(const Element& element)
{
	const auto has = [&](auto&& test)
	{ return std::any_of(element.properties.begin(), element.properties.end(), test); };
	if (element.name == "vertex")
		for (const char* axis : {"x", "y", "z"})
			if (!has([&](const Property& p) { return p.name == axis && !p.listCount; }))
				throw Refused(Reason::syntax, fmt::format("the vertices have no property {}", axis));
	if (element.name == "face" && !has([](const Property& p) { return isCornerList(p) && p.type < Type::float32; }))
		throw Refused(Reason::syntax, "the faces have no integer list vertex_indices");
	if (element.name == "tristrips")
		throw Refused(Reason::syntax, "triangle strips are not read; write the faces one by one");
}
}  // namespace

Soup parsePly(std::string_view bytes)
{
	if (bytes.empty()) throw Refused(Reason::empty, "the file has no content");
	TextCursor cursor(bytes);
	const Header header = readHeader(cursor);
	Values values(header.format, cursor, bytes.size());
	Soup soup;
	for (const Element& element : header.elements)
	{
		checkProperties(element);
		values.reserve(element.count, 1, element.name);
		for (std::size_t i = 0; i < element.count; ++i)
		{
			if (element.name == "vertex")
				readVertex(values, element, soup);
			else if (element.name == "face")
				readFace(values, element, i, soup);
			else
				for (const Property& property : element.properties)
					for (std::size_t n = property.listCount ? readListCount(values, property) : 1; n > 0; --n)
						values.next(property.type);
		}
	}
	return soup;
}
}  // namespace clod::builder
