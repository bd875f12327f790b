// SPDX-License-Identifier: Zlib
#include "demos/render/Image.h"

#include <png.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <csetjmp>
#include <cstdio>
#include <cstring>

namespace clod::demo
{
namespace
{
uint8_t toByte(float v)
{
	return uint8_t(std::lround(std::clamp(v, 0.0f, 1.0f) * 255));
}

// Weights of the source pixels under one target pixel: a box filter, first pixel and overlaps.
struct Overlap
{
	int first;
	std::vector<double> shares;
};

std::vector<Overlap> overlaps(int from, int to)
{
	std::vector<Overlap> list;
	const double scale = double(from) / to;
	for (int i = 0; i < to; ++i)
	{
		const double low = i * scale, high = std::min(double(from), low + std::max(scale, 1e-9));
		Overlap o = {std::min(int(low), from - 1), {}};
		for (int k = o.first; k < from && k < high; ++k)
			o.shares.push_back((std::min(high, k + 1.0) - std::max(low, double(k))) / (high - low));
		list.push_back(o);
	}
	return list;
}

// libpng reports errors by longjmp: no object with a destructor may live in this function.
bool writeRows(std::FILE* file, const Image& image, png_text* text, int textCount)
{
	png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
	png_infop info = png ? png_create_info_struct(png) : nullptr;
	if (!info || setjmp(png_jmpbuf(png)))
	{
		png_destroy_write_struct(&png, &info);
		return false;
	}
	png_init_io(png, file);
	png_set_compression_level(png, 3);
	png_set_IHDR(png, info, png_uint_32(image.width), png_uint_32(image.height), 8, PNG_COLOR_TYPE_RGB,
				 PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
	if (textCount > 0) png_set_text(png, info, text, textCount);
	png_write_info(png, info);
	png_set_filler(png, 0, PNG_FILLER_AFTER);
	for (int y = 0; y < image.height; ++y) png_write_row(png, image.rgba.data() + size_t(y) * size_t(image.width) * 4);
	png_write_end(png, info);
	png_destroy_write_struct(&png, &info);
	return true;
}
}  // namespace

Image::Image(int imageWidth, int imageHeight, Color fill) : width(imageWidth), height(imageHeight)
{
	rgba.resize(size_t(width) * size_t(height) * 4);
	const uint8_t bytes[4] = {toByte(fill.r), toByte(fill.g), toByte(fill.b), toByte(fill.a)};
	for (size_t i = 0; i < rgba.size(); ++i) rgba[i] = bytes[i % 4];
}

Color Image::at(int x, int y) const
{
	const uint8_t* p = rgba.data() + (size_t(y) * size_t(width) + size_t(x)) * 4;
	return {float(p[0]) / 255, float(p[1]) / 255, float(p[2]) / 255, float(p[3]) / 255};
}

Image reduced(const Image& image, int factor)
{
	Image result(image.width / factor, image.height / factor);
	const int samples = factor * factor;
	for (int y = 0; y < result.height; ++y)
		for (int x = 0; x < result.width; ++x)
		{
			int sums[4] = {samples / 2, samples / 2, samples / 2, samples / 2};  // rounds to nearest
			for (int dy = 0; dy < factor; ++dy)
			{
				const size_t row = size_t(y * factor + dy) * size_t(image.width) + size_t(x * factor);
				const uint8_t* p = image.rgba.data() + row * 4;
				for (int k = 0; k < 4 * factor; ++k) sums[k % 4] += p[k];
			}
			uint8_t* out = result.rgba.data() + (size_t(y) * size_t(result.width) + size_t(x)) * 4;
			for (int k = 0; k < 4; ++k) out[k] = uint8_t(sums[k] / samples);
		}
	return result;
}

Image resized(const Image& image, int width, int height)
{
	if (width == image.width && height == image.height) return image;
	Image result(width, height);
	const std::vector<Overlap> columns = overlaps(image.width, width), rows = overlaps(image.height, height);
	for (int y = 0; y < height; ++y)
		for (int x = 0; x < width; ++x)
		{
			const Overlap &row = rows[size_t(y)], &column = columns[size_t(x)];
			double sums[4] = {0, 0, 0, 0};
			for (size_t j = 0; j < row.shares.size(); ++j)
				for (size_t i = 0; i < column.shares.size(); ++i)
				{
					const size_t source = (size_t(row.first) + j) * size_t(image.width) + size_t(column.first) + i;
					for (size_t k = 0; k < 4; ++k)
						sums[k] += row.shares[j] * column.shares[i] * image.rgba[4 * source + k];
				}
			uint8_t* out = result.rgba.data() + (size_t(y) * size_t(width) + size_t(x)) * 4;
			for (int k = 0; k < 4; ++k) out[k] = uint8_t(std::lround(std::min(255.0, sums[k])));
		}
	return result;
}

Result<size_t> writePng(const std::string& path, const Image& image, const PngText& text)
{
	if (image.width < 1 || image.height < 1 || image.rgba.size() != size_t(image.width) * size_t(image.height) * 4)
		return Error{path + ": the picture has no pixels or a wrong number of them."};
	std::vector<png_text> chunks(text.size());
	for (size_t i = 0; i < text.size(); ++i)
	{
		chunks[i] = {};
		chunks[i].compression = PNG_TEXT_COMPRESSION_NONE;
		chunks[i].key = const_cast<char*>(text[i].first.c_str());
		chunks[i].text = const_cast<char*>(text[i].second.c_str());
		chunks[i].text_length = text[i].second.size();
	}
	const std::string aside = path + ".part";
	std::FILE* file = std::fopen(aside.c_str(), "wb");
	if (!file) return Error{aside + ": " + std::strerror(errno) + "."};
	const bool isWritten = writeRows(file, image, chunks.data(), int(chunks.size()));
	const long bytes = std::ftell(file);
	const bool isClosed = std::fclose(file) == 0;
	if (!isWritten || !isClosed || std::rename(aside.c_str(), path.c_str()) != 0)
	{
		const std::string reason = errno ? std::strerror(errno) : "the picture could not be encoded";
		std::remove(aside.c_str());
		return Error{path + ": " + reason + "."};
	}
	return size_t(bytes);
}
}  // namespace clod::demo
