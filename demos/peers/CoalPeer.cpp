// SPDX-License-Identifier: Zlib
// clod-coal as a child process, once a pass.
#include "demos/peers/CoalPeer.h"

#include <fmt/format.h>

#include <cstring>
#include <limits>

#include "cli/Files.h"
#include "cli/Program.h"
#include "demos/peers/CoalExchange.h"
#include "demos/runner/Commands.h"
#include "demos/runner/HierarchyCache.h"
#include "demos/runner/Process.h"

namespace clod::demo
{
namespace
{
using cli::ExitCode;
using cli::Failure;

constexpr std::size_t kAnswerLimit = std::size_t(16) << 30;

void append(std::vector<std::byte>& bytes, const void* data, std::size_t size)
{
	const std::byte* first = static_cast<const std::byte*>(data);
	bytes.insert(bytes.end(), first, first + size);
}

// Takes records off the front of an answer; a short answer is a failure.
class AnswerReader
{
public:
	explicit AnswerReader(std::vector<std::byte> bytes) : m_bytes(std::move(bytes)) {}
	template <class Record>
	Record next()
	{
		if (m_bytes.size() - m_at < sizeof(Record)) throw Failure(ExitCode::failure, "clod-coal answered too little");
		Record record;
		std::memcpy(&record, m_bytes.data() + m_at, sizeof record);
		m_at += sizeof record;
		return record;
	}

private:
	std::vector<std::byte> m_bytes;
	std::size_t m_at = 0;
};

std::vector<std::byte> requestOf(const PoseSample& sample, CoalQuestion question, double scale)
{
	std::vector<std::byte> bytes;
	const CoalRequest head{sample.rows.size(), sample.tolerance, scale, question == CoalQuestion::allContacts};
	append(bytes, &head, sizeof head);
	for (const PoseSample::Row& row : sample.rows)
	{
		const Transform aFromB = relativePose(row.poses, {}, {});
		CoalPose pose;
		for (int i = 0; i < 3; ++i)
		{
			const Vec3& r = aFromB.rotation.row[i];
			pose.rotation[3 * i] = r.x, pose.rotation[3 * i + 1] = r.y, pose.rotation[3 * i + 2] = r.z;
		}
		pose.translation[0] = aFromB.translation.x;
		pose.translation[1] = aFromB.translation.y;
		pose.translation[2] = aFromB.translation.z;
		pose.measured = row.measured;
		append(bytes, &pose, sizeof pose);
	}
	return bytes;
}

PeerAnswer answerOf(AnswerReader& reader, CoalQuestion question)
{
	const CoalRow row = reader.next<CoalRow>();
	PeerAnswer answer;
	answer.microseconds = row.microseconds;
	// The closest pair of meshes that cross is at 0: they touch, how deep is left open.
	answer.gap =
		question == CoalQuestion::distance && row.gap <= 0 ? std::numeric_limits<double>::quiet_NaN() : row.gap;
	for (std::uint64_t i = 0; i < row.contacts; ++i)
	{
		const CoalContact c = reader.next<CoalContact>();
		PeerContact contact;
		contact.point = {c.point[0], c.point[1], c.point[2]};
		contact.normal = {c.normal[0], c.normal[1], c.normal[2]};
		contact.distance = c.distance;
		answer.contacts.push_back(contact);
	}
	return answer;
}

cli::PartialFile temporaryFile(const char* name)
{
	return cli::PartialFile(fmt::format("{}/clod-coal-{}", temporaryDirectory(), name));
}

void write(const cli::PartialFile& file, const ModelMesh& mesh)
{
	writeText(file.temporaryPath(), toObj(mesh));
}

class CoalPeer : public Peer
{
public:
	CoalPeer(PeerInfo info, std::string program, MeshPointer a, MeshPointer b, CoalQuestion question, double scale)
		: Peer(std::move(info)),
		  m_program(std::move(program)),
		  m_question(question),
		  m_scale(scale),
		  m_a(std::move(a)),
		  m_b(std::move(b))
	{
		m_info.sizeA = m_a->triangles.size();
		m_info.sizeB = m_b->triangles.size();
	}
	std::vector<PeerAnswer> pass(const PoseSample& sample) override
	{
		AnswerReader reader(ask(sample));
		const CoalBuild build = reader.next<CoalBuild>();
		m_info.buildSeconds = build.seconds;
		m_info.bytes = build.bytes;
		std::vector<PeerAnswer> answers;
		for (const PoseSample::Row& row : sample.rows)
			if (row.measured) answers.push_back(answerOf(reader, m_question));
		return answers;
	}

private:
	std::vector<std::byte> ask(const PoseSample& sample) const
	{
		// Never committed: gone with these objects.
		const cli::PartialFile a = temporaryFile("a.obj"), b = temporaryFile("b.obj"),
							   request = temporaryFile("request"), answer = temporaryFile("answer");
		write(a, *m_a);
		write(b, *m_b);
		if (const auto problem = cli::writeFile(request.temporaryPath(), requestOf(sample, m_question, m_scale));
			!problem.empty())
			throw Failure(ExitCode::failure, problem);
		const int code = runProgram(
			{m_program, a.temporaryPath(), b.temporaryPath(), request.temporaryPath(), answer.temporaryPath()});
		if (code != 0) throw Failure(ExitCode::failure, fmt::format("{} failed with exit code {}", m_program, code));
		Result<std::vector<std::byte>> bytes = cli::readFile(answer.temporaryPath(), kAnswerLimit);
		if (!bytes) throw Failure(ExitCode::failure, bytes.error());
		return std::move(bytes.value());
	}

	std::string m_program;
	CoalQuestion m_question;
	double m_scale;
	MeshPointer m_a, m_b;
};
}  // namespace

PeerPointer coal(PeerInfo info, const std::string& program, const MeshPointer& a, const MeshPointer& b,
				 CoalQuestion question, double scale)
{
	return std::make_unique<CoalPeer>(std::move(info), program, a, b, question, scale);
}
}  // namespace clod::demo
