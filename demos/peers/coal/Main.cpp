// SPDX-License-Identifier: Zlib
// clod-coal A.obj B.obj REQUEST ANSWER: Coal's closest pair of points, or all its contacts, of two triangle meshes at
// many poses, each call timed. See CoalExchange.h. Built by scripts/peers only: Coal's headers need Eigen and Boost,
// which nothing else of demos/ may touch. Times are CPU times of this, the only, thread.
#include <coal/BVH/BVH_model.h>
#include <coal/collision.h>
#include <coal/distance.h>
#include <time.h>

#include <array>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "../CoalExchange.h"

namespace
{
using namespace clod::demo;
using Model = coal::BVHModel<coal::OBBRSS>;

constexpr std::size_t kMostContacts = 1'000'000;

double threadMicroseconds()
{
	timespec now{};
	clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
	return 1e6 * double(now.tv_sec) + 1e-3 * double(now.tv_nsec);
}

// A mesh as toObj writes it: `v x y z` and `f i j k` lines.
void readObj(const char* path, double scale, Model& model)
{
	std::ifstream file(path);
	if (!file) throw std::runtime_error(std::string("cannot read ") + path);
	std::vector<coal::Vec3s> points;
	std::vector<coal::Triangle> triangles;
	for (std::string line; std::getline(file, line);)
	{
		double x, y, z;
		unsigned i, j, k;
		if (std::sscanf(line.c_str(), "v %lf %lf %lf", &x, &y, &z) == 3)
			points.emplace_back(scale * x, scale * y, scale * z);
		else if (std::sscanf(line.c_str(), "f %u %u %u", &i, &j, &k) == 3)
			triangles.emplace_back(i - 1, j - 1, k - 1);
	}
	model.beginModel(unsigned(triangles.size()), unsigned(points.size()));
	model.addSubModel(points, triangles);
	model.endModel();
}

template <class Record>
Record read(std::ifstream& file)
{
	Record record;
	if (!file.read(reinterpret_cast<char*>(&record), sizeof record)) throw std::runtime_error("the request is short");
	return record;
}

template <class Record>
void write(std::ofstream& file, const Record& record)
{
	file.write(reinterpret_cast<const char*>(&record), sizeof record);
}

coal::Transform3s transformOf(const CoalPose& pose, double scale)
{
	coal::Matrix3s rotation;
	for (int i = 0; i < 9; ++i) rotation(i / 3, i % 3) = pose.rotation[i];
	return {rotation, scale * coal::Vec3s(pose.translation[0], pose.translation[1], pose.translation[2])};
}

// Coal's normals point from A to B.
CoalContact contactOf(const coal::Vec3s& point, const coal::Vec3s& normal, double distance, double scale)
{
	CoalContact contact{};
	for (int i = 0; i < 3; ++i)
	{
		contact.point[i] = point[i] / scale;
		contact.normal[i] = normal.allFinite() ? -normal[i] : 0;
	}
	contact.distance = distance / scale;
	return contact;
}

class Answerer
{
public:
	Answerer(const Model& a, const Model& b, const CoalRequest& request) : m_a(a), m_b(b), m_request(request)
	{
		m_collide.enable_contact = true;
		m_collide.num_max_contacts = kMostContacts;
		m_collide.security_margin = request.scale * request.tolerance;
		m_distance.enable_signed_distance = true;
	}
	CoalRow at(const CoalPose& pose, std::vector<CoalContact>& contacts)
	{
		contacts.clear();
		const coal::Transform3s aFromB = transformOf(pose, m_request.scale);
		return m_request.allContacts ? all(aFromB, contacts) : closest(aFromB, contacts);
	}

private:
	CoalRow closest(const coal::Transform3s& aFromB, std::vector<CoalContact>& contacts)
	{
		coal::DistanceResult result;
		const double start = threadMicroseconds();
		coal::distance(&m_a, coal::Transform3s::Identity(), &m_b, aFromB, m_distance, result);
		const double time = threadMicroseconds() - start;
		// Meshes get no normal from Coal: it is the direction between the nearest points.
		const coal::Vec3s between = result.nearest_points[1] - result.nearest_points[0];
		const coal::Vec3s middle = 0.5 * (result.nearest_points[0] + result.nearest_points[1]);
		contacts.push_back(contactOf(middle, between / between.norm(), result.min_distance, m_request.scale));
		const CoalRow row{time, contacts.back().distance, 1};
		return row;
	}
	CoalRow all(const coal::Transform3s& aFromB, std::vector<CoalContact>& contacts)
	{
		m_result.clear();
		const double start = threadMicroseconds();
		coal::collide(&m_a, coal::Transform3s::Identity(), &m_b, aFromB, m_collide, m_result);
		CoalRow row{threadMicroseconds() - start, std::numeric_limits<double>::infinity(), m_result.numContacts()};
		for (const coal::Contact& contact : m_result.getContacts())
		{
			contacts.push_back(contactOf(contact.pos, contact.normal, contact.penetration_depth, m_request.scale));
			row.gap = std::min(row.gap, contacts.back().distance);
		}
		return row;
	}

	const Model &m_a, &m_b;
	const CoalRequest m_request;
	coal::CollisionRequest m_collide;
	coal::CollisionResult m_result;
	coal::DistanceRequest m_distance;
};

int run(char** argv)
{
	std::ifstream request(argv[3], std::ios::binary);
	const auto head = read<CoalRequest>(request);
	Model a, b;
	const auto start = std::chrono::steady_clock::now();
	readObj(argv[1], head.scale, a);
	readObj(argv[2], head.scale, b);
	const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
	std::ofstream answer(argv[4], std::ios::binary);
	write(answer, CoalBuild{seconds, std::uint64_t(a.memUsage(false)) + std::uint64_t(b.memUsage(false))});
	Answerer answerer(a, b, head);
	std::vector<CoalContact> contacts;
	for (std::uint64_t i = 0; i < head.rows; ++i)
	{
		const auto pose = read<CoalPose>(request);
		const CoalRow row = answerer.at(pose, contacts);
		if (!pose.measured) continue;
		write(answer, row);
		for (const CoalContact& contact : contacts) write(answer, contact);
	}
	return answer.flush() ? 0 : 1;
}
}  // namespace

int main(int argc, char** argv)
{
	if (argc != 5)
	{
		std::fprintf(stderr, "usage: clod-coal A.obj B.obj REQUEST ANSWER (see demos/peers/README.md)\n");
		return 2;
	}
	try
	{
		return run(argv);
	}
	catch (const std::exception& problem)
	{
		std::fprintf(stderr, "clod-coal: %s\n", problem.what());
		return 1;
	}
}
