// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/oracle/Report.h"

#include <fmt/format.h>

namespace clod::oracle
{
namespace
{
double inThousand(int count, int of)
{
	return of > 0 ? 1000.0 * count / of : 0;
}

void addDistribution(nlohmann::ordered_json& row, const std::string& name, std::vector<float>& values)
{
	const std::pair<const char*, double> shares[] = {
		{"median", 0.5}, {"95", 0.95}, {"99", 0.99}, {"99.9", 0.999}, {"worst", 1}};
	for (const auto& share : shares) row[name + "_" + share.first] = quantile(values, share.second);
}
// A line of the table: the first cell to the left, the others to the right.
std::string lineOf(const std::vector<std::string>& cells)
{
	std::string line = fmt::format("{:17}", cells[0]);
	for (std::size_t i = 1; i < cells.size(); ++i)
		line += fmt::format(" {:>{}}", cells[i], i >= 3 && i <= 5 ? 9 : i > 5 ? 8 : 6);
	return line + '\n';
}
}  // namespace

const char* kindName(Kind kind)
{
	switch (kind)
	{
		case Kind::near5: return "5-degrees";
		case Kind::near30: return "30-degrees";
		case Kind::small: return "small";
		default: return "solved";
	}
}

nlohmann::ordered_json rowsOf(FamilyResult& result, const std::string& setting)
{
	nlohmann::ordered_json rows = nlohmann::ordered_json::array();
	for (std::size_t k = 0; k < result.kinds.size(); ++k)
	{
		Tally& tally = result.kinds[k];
		nlohmann::ordered_json row;
		row["setting"] = setting;
		row["family"] = result.family;
		row["poses"] = result.poses;
		row["unmade"] = result.unmade;
		row["mixed"] = result.mixed;
		row["apart"] = result.apart;
		row["ghosts"] = result.ghosts;
		row["worst_claim"] = result.worstClaim;
		row["overlapping"] = result.overlapping;
		row["unanswered"] = result.unanswered;
		row["constraints"] = result.constraints;
		row["motions_of"] = kindName(Kind(k));
		row["motions"] = tally.motions;
		row["free"] = tally.free;
		row["admitted"] = tally.admitted;
		row["changed_per_1000"] = inThousand(tally.changed, tally.motions);
		row["pierced_per_1000"] = inThousand(tally.pierced, tally.motions);
		row["faults_per_1000"] = inThousand(tally.faults(), tally.motions);
		row["best_half_space_per_1000"] = "";
		if (k <= std::size_t(Kind::near30))
			row["best_half_space_per_1000"] = inThousand(tally.bestHalfSpace, tally.motions);
		addDistribution(row, "change", tally.changes);
		addDistribution(row, "depth", tally.depths);
		row["worst_pose"] = result.worstPose;
		rows.push_back(row);
	}
	return rows;
}

std::string csvOf(const nlohmann::ordered_json& rows)
{
	std::string text;
	if (rows.empty()) return text;
	const auto addLine = [&text](const nlohmann::ordered_json& row, bool isHead)
	{
		bool first = true;
		for (const auto& item : row.items())
		{
			if (!first) text += ',';
			first = false;
			const auto& value = item.value();
			text += isHead                    ? item.key()
					: value.is_string()       ? value.get<std::string>()
					: value.is_number_float() ? fmt::format("{:.5g}", value.get<double>())
											  : value.dump();
		}
		text += '\n';
	};
	addLine(rows[0], true);
	for (const auto& row : rows) addLine(row, false);
	return text;
}

std::string tableHead()
{
	return lineOf({"family", "poses", "mixed", "ghosts", "claim", "no answer", "changed", "pierced", "best", "chg 99%",
				   "dep 99%", "at 30", "best", "small", "solved", "worst"}) +
		   lineOf({"", "", "", "of apart", "% of R", "of deep", "/1000", "/1000", "/1000", "share", "% of R", "/1000",
				   "/1000", "/1000", "/1000", "pose"});
}

std::string tableLine(FamilyResult& result)
{
	Tally &near5 = result.kinds[std::size_t(Kind::near5)], &near30 = result.kinds[std::size_t(Kind::near30)];
	const Tally &small = result.of(Kind::small), &solved = result.of(Kind::solved);
	const auto rate = [](int count, const Tally& tally)
	{ return fmt::format("{:.2f}", inThousand(count, tally.motions)); };
	const auto share = [](double value) { return fmt::format("{:.3f}", value); };
	return lineOf({result.family, std::to_string(result.poses), std::to_string(result.mixed),
				   fmt::format("{}/{}", result.ghosts, result.apart), share(100 * result.worstClaim),
				   fmt::format("{}/{}", result.unanswered, result.overlapping), rate(near5.changed, near5),
				   rate(near5.pierced, near5), rate(near5.bestHalfSpace, near5), share(quantile(near5.changes, 0.99)),
				   share(100 * quantile(near5.depths, 0.99)), rate(near30.faults(), near30),
				   rate(near30.bestHalfSpace, near30), rate(small.faults(), small), rate(solved.faults(), solved),
				   std::to_string(result.worstPose)});
}

std::string described(const Trial& trial)
{
	const Verdict& v = trial.verdict;
	const RelativeMotion& motion = trial.which.motion;
	std::string text = fmt::format(
		"pair {}, surfaces {} and {}{}, R {:.6g}; {}, depth {:.3g} % of R, {}; deepest claim {:.3g} % of R\n"
		"motion: linear {:.5g} {:.5g} {:.5g}, angular {:.5g} {:.5g} {:.5g}, dt {:.6g}\n",
		trial.pair, trial.answer.surfaceA, trial.answer.surfaceB, trial.answer.isMixed ? " and others" : "",
		trial.radius, v.isApart ? "apart" : "not apart", 100 * v.startDepth,
		v.isAnswered ? "answered" : "not answered", 100 * v.claim, motion.linear.x, motion.linear.y, motion.linear.z,
		motion.angular.x, motion.angular.y, motion.angular.z, motion.timeStep);
	for (const Vec3& row : trial.which.aFromB.rotation.row)
		text += fmt::format("aFromB: {:.9f} {:.9f} {:.9f}\n", row.x, row.y, row.z);
	const Vec3& at = trial.which.aFromB.translation;
	text += fmt::format("at: {:.9g} {:.9g} {:.9g}\n", at.x, at.y, at.z);
	for (const Constraint& c : trial.answer.constraints)
	{
		const double closing = -motion.timeStep * dot(c.normal, motion.velocity(c.point));
		text += fmt::format(
			"point {:.5f} {:.5f} {:.5f} normal {:.5f} {:.5f} {:.5f} distance {:.4g} % of R, closing {:.4g} %\n",
			c.point.x, c.point.y, c.point.z, c.normal.x, c.normal.y, c.normal.z, 100 * c.distance / trial.radius,
			100 * closing / trial.radius);
	}
	for (std::size_t k = 0; k < v.kinds.size(); ++k)
	{
		const Tally& t = v.kinds[k];
		text += fmt::format("{}: {} motions, {} free, {} admitted; {} changed, {} pierced\n", kindName(Kind(k)),
							t.motions, t.free, t.admitted, t.changed, t.pierced);
	}
	return text + fmt::format("within 5 degrees a free motion is changed by up to {:.3g} of it, an admitted one gets "
							  "{:.3g} % of R deep\n",
							  v.worstOf[0], 100 * v.worstOf[1]);
}
}  // namespace clod::oracle
