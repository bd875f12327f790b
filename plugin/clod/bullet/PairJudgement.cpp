// SPDX-License-Identifier: Zlib
// What a pair says about its own contacts: levels, certified error, depth, and what it warns of; and what is saved of
// it.
#include <algorithm>

#include "clod/bullet/BodyState.h"
#include "clod/bullet/PairState.h"
#include "clod/query/StopRule.h"

namespace clod
{
namespace
{
constexpr double kSeldomMet = 0.25;  // so little is expected of what nobody looked at: it may be met, but hardly ever is

std::string nameOf(const btCollisionObject* object)
{
	if (!object) return "none";
	const auto* shape = dynamic_cast<const btClodShape*>(object->getCollisionShape());
	std::string name = "body " + std::to_string(object->getWorldArrayIndex());
	if (object->getUserIndex() != -1) name += " (user index " + std::to_string(object->getUserIndex()) + ")";
	if (shape && !shape->name().empty()) name += " of " + shape->name();
	return name;
}

// As numbers, one after the other.
class Numbers
{
public:
	explicit Numbers(std::vector<double>& all) : m_all(all) {}
	template <class... All>
	void add(const All&... values)
	{
		(addOne(values), ...);
	}

private:
	void addOne(const Vec3& v) { m_all.insert(m_all.end(), {v.x, v.y, v.z}); }
	void addOne(const Transform& t) { add(t.rotation.row[0], t.rotation.row[1], t.rotation.row[2], t.translation); }
	void addOne(std::uint64_t bits) { add(std::uint32_t(bits), std::uint32_t(bits >> 32)); }
	template <class Number>
	void addOne(Number number)
	{
		m_all.push_back(double(number));
	}
	std::vector<double>& m_all;
};
}  // namespace

double PairState::surprise() const
{
	const double dt = m_foreseen.timeStep;
	if (!(dt > 0)) return 0;
	const RelativeMotion ofA = solvedMotion(*m_report.objectA);
	RelativeMotion ofB = solvedMotion(*m_report.objectB);
	if (m_foreseen.bIsPoint) ofB = {ofB.velocity(toVec3(m_report.objectB->getWorldTransform().getOrigin())), {}, 0};
	const RelativeMotion now = relativeMotion(ofA, ofB, m_foreseen.worldFromA, m_foreseen.scale, dt);
	const auto wayOf = [&](const RelativeMotion& motion)
	{ return motion.speedWithin(m_foreseen.center, m_foreseen.radius) * dt; };
	// What is met on so short a way was near from the start, and so it is a contact already.
	const double skin = m_foreseen.skin, nearest = kRestingShare / kSkinShare * skin;
	if (wayOf(now) <= nearest) return 0;
	const double otherWay = wayOf({now.linear - m_foreseen.motion.linear, now.angular - m_foreseen.motion.angular, dt});
	if (otherWay > m_foreseen.spare + skin) return otherWay / skin;
	const double missed = m_foreseen.missed / skin;
	// A solver knows the points to first order for any motion. What they miss is how the bodies turn meanwhile.
	const double turn = dt * std::max(length(ofA.angular), length(ofB.angular));
	const double bent = std::max(missed, std::min(1.0, turn) * otherWay / skin);
	return otherWay <= nearest + skin ? bent : std::max(bent, 1 + kSeldomMet * (otherWay - nearest) / skin);
}

double PairState::unmet() const
{
	const double dt = m_foreseen.timeStep;
	return dt > 0 ? m_manifolds.unmetWay(dt) / (m_foreseen.skin * m_foreseen.scale) : 0;
}

void PairState::noteSides(const PairPose& pose)
{
	const std::array<const btCollisionObjectWrapper*, 2> bodies{pose.a, pose.b};
	const bool isFelt = !m_isClosestPoints && pose.responds && !m_result.pairs.empty();
	Sides sides;
	for (std::size_t i = 0; i < 2; ++i)
	{
		const btCollisionObject& object = *bodies[i]->getCollisionObject();
		if (!isFelt || !(object.isStaticOrKinematicObject() || m_children[i] >= 0)) continue;
		sides[i] = Side();
		Side& side = *sides[i];
		side.object = &object;
		side.child = m_children[i];
		side.objectFromSide = inverse(toTransform(object.getWorldTransform())) * toTransform(bodies[i]->getWorldTransform());
		side.hierarchy = i == 0 ? pose.asked.a : pose.asked.b;
		side.surface = i == 0 ? nullptr : m_partnerSurface;
		side.unit = pose.scale();
		side.radius = i == 0 ? pose.rules.radiusA : pose.rules.radiusB;
		side.level = m_result.stats.finestLevel;
	}
	tell(std::move(sides));
}

void PairState::tell(Sides sides)
{
	if (!m_told && !sides[0] && !sides[1]) return;
	if (!m_told) m_told = std::make_unique<Told>();
	if (m_told->dispatch != m_shared.dispatch) m_told->before = std::exchange(m_told->now, {});
	m_told->dispatch = m_shared.dispatch;
	m_told->now = std::move(sides);
}

const PairState::Sides& PairState::told() const
{
	static const Sides kNothing{};
	if (!m_told) return kNothing;
	return m_shared.dispatch > 0 && m_told->dispatch == m_shared.dispatch ? m_told->before : m_told->now;
}

std::optional<PairState::Saved> PairState::save() const
{
	if (m_isClosestPoints || m_seenA.shape == nullptr) return std::nullopt;
	Saved saved;
	saved.objects = {m_report.objectA, m_report.objectB};
	saved.children = m_children;
	saved.seenA = m_seenA;
	saved.seenB = m_seenB;
	if (m_answered) saved.answered = *m_answered;
	saved.followed = m_followed;
	saved.lastOrder = m_lastOrder;
	saved.foreseen = m_foreseen;
	saved.clusters = m_clusters;
	saved.report = m_report;
	saved.heldError = m_heldError;
	saved.facets = m_facets;
	saved.result = m_result;
	saved.partnerStats = m_partnerStats;
	if (m_mesh) saved.mesh = m_mesh->gathered();
	saved.sides = told();
	saved.manifolds = m_manifolds.save();
	return saved;
}

bool PairState::isOf(const Saved& saved) const
{
	return saved.objects[0] == m_report.objectA && saved.objects[1] == m_report.objectB &&
		   saved.children == m_children && saved.seenA == m_seenA && saved.seenB == m_seenB;
}

// The hierarchies that the caches are of are those that the shapes still have, if there is any.
void PairState::restore(const Saved& saved)
{
	if (m_isClosestPoints) return;
	m_seenA = saved.seenA;
	m_seenB = saved.seenB;
	m_answered = saved.answered ? std::make_unique<Question>(*saved.answered) : nullptr;
	m_followed = saved.followed;
	m_lastOrder = saved.lastOrder;
	m_foreseen = saved.foreseen;
	m_clusters = saved.clusters;
	m_report = saved.report;
	m_report.result = &m_result;
	m_report.clusters = &m_clusters;
	m_heldError = saved.heldError;
	m_facets = saved.facets;
	m_result = saved.result;
	m_partnerStats = saved.partnerStats;
	m_partnerSurface.reset();  // of what will be gathered again
	m_mesh = saved.mesh ? std::make_unique<NearMesh>(*saved.mesh) : nullptr;
	const bool isTold = saved.sides[0] || saved.sides[1];
	m_told = isTold ? std::make_unique<Told>(Told{saved.sides, {}, 0}) : nullptr;
	m_manifolds.restore(saved.manifolds);
}

void PairState::Saved::addTo(std::vector<double>& numbers) const
{
	if (clusters.isEmpty()) return;
	Numbers all(numbers);
	all.add(report.aFromB, followed, heldError, foreseen.spare, foreseen.missed, foreseen.motion.linear, foreseen.motion.angular,
			facets.aFromB, facets.through, facets.wayOut, facets.isMadeIn, facets.levels.overlap, facets.levels.isOther,
			mesh ? mesh->hash : 0);
	for (const SwitchMemory::Levels& levels : facets.levels.asked) all.add(levels.a, levels.b);
	for (const FacetRecord& facet : facets.reduced) all.add(facet.feature, facet.distance, facet.then);
	for (const AcceptedPair& pair : result.pairs) all.add(pair.nodeA, pair.nodeB);
	if (answered) all.add(answered->aFromB, answered->way, answered->settings.tolerance);
	for (const HeldPoint& held : clusters.points())
	{
		const ContactPoint& point = held.point;
		all.add(held.impulse, point.pointOnA, point.pointOnB, point.normal, point.height, point.bend, point.slowOverlap,
				point.idle, point.feature, point.goesOn, point.rebounds);
	}
	for (const ManifoldSet::Saved::One& manifold : manifolds.manifolds)
		for (const btManifoldPoint& point : manifold.points)
			all.add(point.m_appliedImpulse, point.m_appliedImpulseLateral1, point.m_appliedImpulseLateral2,
					point.m_distance1);
}

std::string PairState::bodies() const
{
	return nameOf(m_report.objectA) + " and " + nameOf(m_report.objectB);
}

void PairState::sayOnce(unsigned cause, const std::string& message)
{
	if ((m_warned & cause) != 0) return;
	m_warned |= cause;
	m_toSay.emplace_back(cause, bodies() + ": " + message);
}

void PairState::warnOnce(bool now, unsigned cause, const char* what)
{
	if (!now || (m_warned & cause) != 0) return;
	double radius = double(m_report.hierarchyA->asset().radius);
	if (m_report.hierarchyB) radius = std::min(radius, double(m_report.hierarchyB->asset().radius));
	sayOnce(cause, std::string(what) + " (radius " + std::to_string(radius) + ", motion of a step " +
					   std::to_string(m_report.motion) + ", hierarchy unit)");
}

// Is there an overlap whose depth the points do not tell, only a way out of it? So it is where a component is wholly
// inside the other body, or where what is inside is too far from the surface for any facet.
bool PairState::isDeep() const
{
	return m_facets.isDeep() || (m_result.deep && !m_context.searchGap);
}

// See PairReport::contactError.
double PairState::errorOfContacts(const PairPose& pose) const
{
	if (!pose.isOfTwo()) return m_partnerStats.errorBound;
	double error = 0;
	for (const AcceptedPair& pair : m_result.pairs)
	{
		const Node& a = pose.hierarchyA().node(pair.nodeA);
		const Node& b = pose.hierarchyB().node(pair.nodeB);
		error = std::max(error, certifiedErrorApart(a, b));
	}
	return error;
}

void PairState::report(const PairPose& pose)
{
	m_report.points = std::uint32_t(m_clusters.points().size());
	m_report.clusterCount = 0;
	for (std::size_t slot = 0; slot < m_clusters.slots(); ++slot) m_report.clusterCount += m_clusters.count(slot) > 0 ? 1 : 0;
	m_report.contactError = errorOfContacts(pose);
	m_report.finestLevel = m_result.stats.finestLevel;
	m_report.coarsestLevel = m_result.stats.coarsestLevel;
	const double wall = pose.thinnestWall();
	m_report.deep = isDeep();
	m_report.fast = wall > 0 && m_report.motion > wall;
	m_report.loose = wall > 0 && m_report.contactError > wall;
	// Coarser than asked because finer levels were not loaded, and not for want of budget.
	const bool isWanting = (pose.hierarchyA().isCoarse() || (pose.isOfTwo() && pose.hierarchyB().isCoarse())) &&
						   m_report.metric.coarsening == 1 && m_result.excess > 0;
	if (isWanting && m_report.metricError.empty())
		m_report.metricError = "coarser contacts than it asks for, by a factor of " + std::to_string(m_result.excess) +
							   ": finer levels were not loaded";
	if (m_isClosestPoints) return;
	if (isWanting) sayOnce(128, "a pair's metric is missed: " + m_report.metricError);
	warnOnce(m_report.deep, 1, "two bodies overlap deeper than their contacts can prove");
	const auto isBeyondWalls = [&](bool isBeyondThinnest, double length)
	{ return isBeyondThinnest && length > pose.usualWall(); };
	warnOnce(isBeyondWalls(m_report.fast, m_report.motion), 2,
			 "a step moves two bodies farther than their walls are thick: use smaller steps");
	warnOnce(isBeyondWalls(m_report.loose, m_report.contactError), 4,
			 "the contact error bound exceeds the walls' thickness: use a stricter metric");
}
}  // namespace clod
