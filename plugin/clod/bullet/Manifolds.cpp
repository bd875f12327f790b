// SPDX-License-Identifier: Zlib
#include "clod/bullet/Manifolds.h"

#include <BulletDynamics/Dynamics/btRigidBody.h>

#include <algorithm>
#include <typeinfo>
#include <utility>

#include "clod/bullet/BodyState.h"
#include "clod/bullet/SolverTerms.h"
#include "clod/collide/Room.h"
#include "clod/manifold/BodyBalance.h"
#include "clod/query/Query.h"

namespace clod
{
namespace
{
// The child's index where the body is a compound.
int childOr(int otherwise, const btCollisionObjectWrapper& wrapper)
{
	return wrapper.m_parent ? wrapper.m_index : otherwise;
}
// What Bullet combines of the two bodies' materials. It is the same for all points of a pair.
struct Material
{
	btScalar friction, restitution, rolling, spinning;
	explicit Material(const btManifoldResult& out)
	{
		const btCollisionObject* body0 = out.getBody0Internal();
		const btCollisionObject* body1 = out.getBody1Internal();
		friction = gCalculateCombinedFrictionCallback(body0, body1);
		restitution = gCalculateCombinedRestitutionCallback(body0, body1);
		rolling = gCalculateCombinedRollingFrictionCallback(body0, body1);
		spinning = gCalculateCombinedSpinningFrictionCallback(body0, body1);
	}
};

// Would addContactPoint give the point these same materials, and has nobody changed what it writes?
bool isMadeOf(const Material& material, const btManifoldPoint& point)
{
	return point.m_combinedFriction == material.friction && point.m_combinedRollingFriction == material.rolling &&
		   point.m_combinedSpinningFriction == material.spinning && point.m_contactMotion1 == 0 &&
		   point.m_contactMotion2 == 0 && point.m_contactCFM == 0 && point.m_frictionCFM == 0;
}

constexpr btScalar kSlips = btScalar(0.9999);  // of what friction could give in the last step: bodies that took so much slip

// What a thread needs while it writes a pair.
struct Scratch
{
	std::array<btManifoldPoint, std::size_t(kMaxClusters) * kClusterPoints> old;      // points of the last write,
	std::array<btManifoldPoint*, std::size_t(kMaxClusters) * kClusterPoints> live{};  // where they are still there
	std::array<btManifoldPoint, kClusterPoints> fresh;                            // of the slot being written
	BodyBalance balance;
};
Scratch& scratch()
{
	thread_local Scratch buffer;
	return buffer;
}
}  // namespace

int childOf(const btCollisionObjectWrapper& wrapper)
{
	return childOr(-1, wrapper);
}

ManifoldSet::Written::Written(const btManifoldPoint& p)
	: localPointA(p.m_localPointA),
	  localPointB(p.m_localPointB),
	  normal(p.m_normalWorldOnB),
	  distance(p.m_distance1),
	  erp(p.m_contactERP),
	  restitution(p.m_combinedRestitution),
	  flags(p.m_contactPointFlags)
{
}

ManifoldSet::ManifoldSet(btDispatcher& dispatcher, btPersistentManifold* shared)
	: m_dispatcher(dispatcher), m_shared(shared)
{
}

ManifoldSet::~ManifoldSet()
{
	for (btPersistentManifold* manifold : m_manifolds)
		if (manifold) m_dispatcher.releaseManifold(manifold);
}

void ManifoldSet::append(btManifoldArray& manifolds) const
{
	for (btPersistentManifold* manifold : m_manifolds)
		if (manifold) manifolds.push_back(manifold);
}

ManifoldSet::Saved ManifoldSet::save() const
{
	Saved saved;
	saved.slots = m_slots;
	saved.ground = m_ground;
	for (std::size_t i = 0; i < m_manifolds.size(); ++i)
		if (btPersistentManifold* const manifold = m_manifolds[i])
		{
			Saved::One& one = saved.manifolds[i];
			one = {manifold->getBody0(), manifold->getBody1(), manifold->getContactBreakingThreshold(), {}};
			for (int k = 0; k < manifold->getNumContacts(); ++k)
			{
				one.points.push_back(manifold->getContactPoint(k));
				one.points.back().m_userPersistentData = nullptr;
			}
		}
	return saved;
}

btPersistentManifold* ManifoldSet::newManifold(std::size_t index, const btCollisionObject& first,
											   const btCollisionObject& second)
{
	btPersistentManifold* const manifold = m_dispatcher.getNewManifold(&first, &second);
	manifold->m_companionIdA = int(index);  // for the SolverOrder
	return manifold;
}

void ManifoldSet::restore(const Saved& saved)
{
	m_slots = saved.slots;
	m_ground = saved.ground;
	for (std::size_t i = 0; i < m_manifolds.size(); ++i)
	{
		btPersistentManifold*& manifold = m_manifolds[i];
		const Saved::One& one = saved.manifolds[i];
		if (manifold && !one.body0) m_dispatcher.releaseManifold(std::exchange(manifold, nullptr));
		if (!one.body0) continue;
		if (!manifold) manifold = newManifold(i, *one.body0, *one.body1);
		for (int k = 0; k < manifold->getNumContacts(); ++k) manifold->clearUserCache(manifold->getContactPoint(k));
		manifold->setContactBreakingThreshold(one.breakingThreshold);
		manifold->setNumContacts(int(one.points.size()));
		for (std::size_t k = 0; k < one.points.size(); ++k) manifold->getContactPoint(int(k)) = one.points[k];
	}
}

bool ManifoldSet::carry() const
{
	for (std::size_t i = 0; i < m_slots.size(); ++i)
		for (int k = 0; k < m_slots[i].count && k < m_manifolds[i]->getNumContacts(); ++k)
			if (m_manifolds[i]->getContactPoint(k).m_appliedImpulse > 0) return true;
	return false;
}

Vec3 ManifoldSet::impulse() const
{
	Vec3 sum;
	for (std::size_t i = 0; i < m_slots.size(); ++i)
		for (int k = 0; k < m_slots[i].count && k < m_manifolds[i]->getNumContacts(); ++k)
		{
			const btManifoldPoint& point = m_manifolds[i]->getContactPoint(k);
			sum += double(point.m_appliedImpulse) * toVec3(point.m_normalWorldOnB);
		}
	return sum;
}

btManifoldPoint* ManifoldSet::find(btPersistentManifold& manifold, const Slot& slot, std::size_t j)
{
	std::size_t before = 0;
	for (std::size_t i = 0; i < j; ++i) before += slot.points[i].isEqual(slot.points[j]) ? 1 : 0;
	for (int k = 0; k < manifold.getNumContacts(); ++k)
		if (slot.points[j].isOf(manifold.getContactPoint(k)) && before-- == 0) return &manifold.getContactPoint(k);
	return nullptr;
}

void ManifoldSet::readImpulses(HeldClusters& written) const
{
	for (std::size_t i = 0; i < m_slots.size(); ++i)
		for (std::size_t j = 0; j < std::min(std::size_t(m_slots[i].count), std::size_t(written.count(i))); ++j)
		{
			const btManifoldPoint* point = find(*m_manifolds[i], m_slots[i], j);
			written.at(i, j).impulse = point ? double(point->m_appliedImpulse) : 0;
		}
}

bool ManifoldSet::isOf(const Ground& ground, const WorldFrame& frame)
{
	return ground.a == frame.a->getCollisionObject() && ground.b == frame.b->getCollisionObject() &&
		   ground.childA == childOf(*frame.a) && ground.childB == childOf(*frame.b) &&
		   ground.aIsFirst == frame.aIsFirst && ground.scale == frame.scale &&
		   ground.breakingThreshold == frame.breakingThreshold;
}

bool ManifoldSet::isOn(const Ground& ground, const WorldFrame& frame)
{
	return isOf(ground, frame) && ground.poseA == ground.a->getWorldTransform() &&
		   ground.poseB == ground.b->getWorldTransform() && ground.worldFromA == frame.worldFromA;
}

// May points stay from one dispatch to the next? Not for bodies whose callbacks or flags act on each point as it is
// added.
bool ManifoldSet::mayKeep(const WorldFrame& frame, const btManifoldResult& out) const
{
	constexpr int kPerPoint =
		btCollisionObject::CF_HAS_CONTACT_STIFFNESS_DAMPING | btCollisionObject::CF_HAS_FRICTION_ANCHOR;
	if (m_shared || !frame.a || typeid(out) != typeid(btManifoldResult)) return false;
	const int flags =
		frame.a->getCollisionObject()->getCollisionFlags() | frame.b->getCollisionObject()->getCollisionFlags();
	const bool calls = gContactAddedCallback && (flags & btCollisionObject::CF_CUSTOM_MATERIAL_CALLBACK) != 0;
	return !calls && (flags & kPerPoint) == 0;
}

// Is every point there still, and would the same materials be written?
bool ManifoldSet::isAsLeft(const WorldFrame& frame, const btManifoldResult& out) const
{
	if (!m_ground || !mayKeep(frame, out) || !isOf(*m_ground, frame)) return false;
	const Material material(out);
	for (std::size_t i = 0; i < m_manifolds.size(); ++i)
	{
		if (!m_manifolds[i]) continue;
		const int count = i < m_slots.size() ? m_slots[i].count : 0;
		if (m_manifolds[i]->getNumContacts() != count) return false;
		if (count == 0) continue;
		const Slot& slot = m_slots[i];
		if (m_manifolds[i]->getContactBreakingThreshold() != slot.breakingThreshold) return false;
		if (slot.restitution != material.restitution) return false;
		for (std::size_t j = 0; j < std::size_t(count); ++j)
		{
			const btManifoldPoint& point = m_manifolds[i]->getContactPoint(int(j));
			if (!slot.points[j].isUnchanged(point) || !isMadeOf(material, point)) return false;
		}
	}
	return true;
}

void ManifoldSet::refresh(std::size_t slot, HeldClusters& written, btManifoldResult& out)
{
	for (std::size_t j = 0; j < std::size_t(m_slots[slot].count); ++j)
		written.at(slot, j).impulse = double(m_manifolds[slot]->getContactPoint(int(j)).m_appliedImpulse);
	out.setPersistentManifold(m_manifolds[slot]);
	out.refreshContactPoints();
}

bool ManifoldSet::keep(HeldClusters& written, const WorldFrame& frame, btManifoldResult& out)
{
	if (!isAsLeft(frame, out) || !isOn(*m_ground, frame)) return false;
	for (std::size_t i = 0; i < m_slots.size(); ++i)
	{
		if (m_slots[i].count == 0) continue;
		refresh(i, written, out);
		setDistances(*m_manifolds[i], m_slots[i]);
	}
	return true;
}

// The points are judged as a whole, because anchoring some and not others turns the bodies. Each of Bullet's two
// friction directions has the limit of the whole friction, and an anchor of what slips would make both reach it.
bool ManifoldSet::slip() const
{
	btVector3 friction(0, 0, 0);
	btScalar most = 0;
	for (std::size_t i = 0; i < m_slots.size(); ++i)
		for (int k = 0; k < m_slots[i].count; ++k)
		{
			const btManifoldPoint& point = m_manifolds[i]->getContactPoint(k);
			const btScalar sign = m_manifolds[i]->getBody0() == m_ground->a ? btScalar(1) : btScalar(-1);
			friction += sign * (point.m_appliedImpulseLateral1 * point.m_lateralFrictionDir1 +
								point.m_appliedImpulseLateral2 * point.m_lateralFrictionDir2);
			most += point.m_combinedFriction * point.m_appliedImpulse;
		}
	return friction.length() >= kSlips * most;
}

// As LevelSwitch would, that is not asked while the points follow: the bodies sink as if the point were found anew.
void ManifoldSet::letDown(const WorldFrame& frame, HeldPoint& held, ContactPoint& now)
{
	now.height = std::max(now.height, frame.switchSpeed * frame.timeStep / frame.scale);
	held.point.idle = held.impulse > 0 ? 0 : held.point.idle + frame.timeStep;
}

bool ManifoldSet::follow(HeldClusters& written, const WorldFrame& frame, btManifoldResult& out)
{
	if (!isAsLeft(frame, out)) return false;
	const bool slips = slip();
	for (std::size_t i = 0; i < m_slots.size(); ++i)
		if (m_slots[i].count > 0) refresh(i, written, out);
	for (std::size_t i = 0; i < m_slots.size(); ++i)
	{
		Slot& slot = m_slots[i];
		if (slot.count == 0) continue;
		for (int k = 0; k < m_manifolds[i]->getNumContacts(); ++k)
			for (std::size_t j = 0; j < std::size_t(slot.count); ++j)
			{
				btManifoldPoint& point = m_manifolds[i]->getContactPoint(k);
				if (!slot.points[j].isOf(point)) continue;
				ContactPoint now = written.at(i, j).point;
				now.height = double(point.m_distance1) / frame.scale;
				if (now.goesOn) letDown(frame, written.at(i, j), now);
				now.slowOverlap = std::max(0.0, std::min({now.slowOverlap, frame.slowOverlap / frame.scale, -now.height}));
				point.m_combinedRestitution = slot.restitution;
				setSolverTerms(now, frame, point);
				// An anchor keeps the two places together that touched first.
				if (slips)
					point.m_contactPointFlags &= ~BT_CONTACT_FLAG_FRICTION_ANCHOR;
				else
					point.m_contactPointFlags |= BT_CONTACT_FLAG_FRICTION_ANCHOR;
				slot.points[j] = Written(point);
			}
	}
	m_ground->poseA = m_ground->a->getWorldTransform();
	m_ground->poseB = m_ground->b->getWorldTransform();
	m_ground->worldFromA = frame.worldFromA;
	return true;
}

// A point that goes on in another slot keeps its user data, which is moved to the copy.
void ManifoldSet::beginWrite(const HeldClusters& clusters)
{
	Scratch& buffer = scratch();
	buffer.live = {};
	for (std::size_t i = 0; i < m_slots.size(); ++i)
		for (std::size_t j = 0; j < std::size_t(m_slots[i].count); ++j)
			if (btManifoldPoint* point = find(*m_manifolds[i], m_slots[i], j))
			{
				buffer.old[i * kClusterPoints + j] = *point;
				buffer.live[i * kClusterPoints + j] = point;
			}
	m_slots.resize(clusters.slots());
	shrinkRoom(m_slots, clusters.slots());
	for (const HeldPoint& point : clusters.points())
	{
		const std::uint32_t from = point.previous;
		if (from != kNone && buffer.live[from]) buffer.live[from]->m_userPersistentData = nullptr;
	}
}

bool ManifoldSet::openSlot(std::size_t index, HeldClusters& clusters, const WorldFrame& frame, btManifoldResult& out)
{
	btPersistentManifold*& manifold = m_manifolds[index];
	if (clusters.count(index) == 0)
	{
		// Emptied and kept for later: to release it during a dispatch breaks Bullet's threaded dispatcher.
		if (manifold && manifold->getNumContacts() > 0) manifold->clearManifold();
		if (index < m_slots.size()) m_slots[index].count = 0;
		return false;
	}
	if (!manifold && !m_shared)
	{
		manifold = newManifold(index, *(frame.aIsFirst ? frame.a : frame.b)->getCollisionObject(),
							   *(frame.aIsFirst ? frame.b : frame.a)->getCollisionObject());
	}
	m_target = m_shared ? m_shared : manifold;
	out.setPersistentManifold(m_target);
	m_freshCount = 0;
	if (m_shared) return true;
	double highest = 0;
	for (std::size_t i = 0; i < clusters.count(index); ++i) highest = std::max(highest, clusters.at(index, i).point.height);
	Slot& slot = m_slots[index];
	slot.breakingThreshold = btScalar(frame.breakingThreshold + 1.01 * highest * frame.scale);
	slot.restitution = Material(out).restitution;
	m_target->setContactBreakingThreshold(slot.breakingThreshold);
	m_wasEmpty = m_target->getNumContacts() == 0;
	for (int k = 0; k < m_target->getNumContacts(); ++k) m_target->clearUserCache(m_target->getContactPoint(k));
	return true;
}

// Lets gContactAddedCallback find the data again that it has put at a point, as with Bullet's own algorithms: there a
// point at the same place is replaced, and its data stay.
void ManifoldSet::standIn(const btVector3& onBody0, btManifoldPoint& before)
{
	if (!before.m_userPersistentData) return;
	m_target->setNumContacts(2);
	btManifoldPoint& point = m_target->getContactPoint(1);
	point = btManifoldPoint();
	point.m_localPointA = m_target->getBody0()->getWorldTransform().invXform(onBody0);
	point.m_appliedImpulseLateral1 = 1;  // it slips: where bodies have anchors only such a one is replaced
	std::swap(point.m_userPersistentData, before.m_userPersistentData);
}

void ManifoldSet::writePoint(const HeldPoint& held, const Parts& parts, const WorldFrame& frame, btManifoldResult& out)
{
	const ContactPoint& point = held.point;
	const bool aIsManifoldBody0 = m_target->getBody0() == frame.a->getCollisionObject();
	const bool aIsResultBody0 = out.getBody0Internal() == frame.a->getCollisionObject();
	const int partA = childOr(int(parts[0]), *frame.a), partB = childOr(int(parts[1]), *frame.b);
	out.setShapeIdentifiersA(aIsResultBody0 ? partA : partB, int(aIsResultBody0 ? point.faceA : point.faceB));
	out.setShapeIdentifiersB(aIsResultBody0 ? partB : partA, int(aIsResultBody0 ? point.faceB : point.faceA));

	const Vec3 normal = frame.worldFromA.rotation * point.normal;
	const Vec3 onB = frame.worldFromA * (frame.scale * point.pointOnB);
	const double depth = point.height * frame.scale;
	const Vec3 onA = onB + depth * normal;
	const std::uint32_t from = held.previous;
	Scratch& buffer = scratch();
	const bool goesOn = from != kNone && buffer.live[from];

	// One real point at a time: a far-away stand-in keeps Bullet from matching it to its neighbours, and from taking
	// every point for the beginning of a contact.
	const int place = m_shared ? -1 : (m_wasEmpty && m_freshCount == 0 ? 0 : 1);
	if (place >= 0) m_target->setNumContacts(place);
	if (place == 1)
	{
		m_target->getContactPoint(0) = btManifoldPoint();
		m_target->getContactPoint(0).m_localPointA.setValue(BT_LARGE_FLOAT, BT_LARGE_FLOAT, BT_LARGE_FLOAT);
		if (goesOn) standIn(toBullet(aIsManifoldBody0 ? onA : onB), buffer.old[from]);
	}
	out.addContactPoint(toBullet(aIsManifoldBody0 ? normal : -normal), toBullet(aIsManifoldBody0 ? onB : onA),
						btScalar(depth));
	if (place < 0 || m_target->getNumContacts() <= place) return;
	btManifoldPoint& fresh = buffer.fresh[std::size_t(m_freshCount++)];
	fresh = m_target->getContactPoint(place);
	m_target->getContactPoint(place).m_userPersistentData = nullptr;
	fresh.m_appliedImpulse = goesOn ? btScalar(frame.carriedShare) * buffer.old[from].m_appliedImpulse : 0;
	setSolverTerms(point, frame, fresh);
	if (!goesOn) return;
	btManifoldPoint& old = buffer.old[from];
	if (!fresh.m_userPersistentData) std::swap(fresh.m_userPersistentData, old.m_userPersistentData);
	fresh.m_prevRHS = old.m_prevRHS;
	fresh.m_appliedImpulseLateral1 = old.m_appliedImpulseLateral1;
	fresh.m_appliedImpulseLateral2 = old.m_appliedImpulseLateral2;
	fresh.m_lifeTime = old.m_lifeTime;
}

void ManifoldSet::closeSlot(std::size_t index, btManifoldResult& out)
{
	if (m_shared) return;
	Slot& slot = m_slots[index];
	m_target->setNumContacts(m_freshCount);
	slot.count = m_freshCount;
	for (int i = 0; i < m_freshCount; ++i)
	{
		const btManifoldPoint& fresh = scratch().fresh[std::size_t(i)];
		m_target->getContactPoint(i) = fresh;
		slot.points[std::size_t(i)] = Written(fresh);
	}
	out.refreshContactPoints();
	setDistances(*m_target, slot);
}

// Sets the distances again after Bullet's refresh, which computes them from the points' places and may drop points.
void ManifoldSet::setDistances(btPersistentManifold& manifold, const Slot& slot)
{
	for (int k = 0; k < manifold.getNumContacts(); ++k)
		for (std::size_t i = 0; i < std::size_t(slot.count); ++i)
			if (slot.points[i].isOf(manifold.getContactPoint(k)))
				manifold.getContactPoint(k).m_distance1 = slot.points[i].distance;
}

void ManifoldSet::endWrite(const HeldClusters& clusters, const WorldFrame& frame, const btManifoldResult& out)
{
	m_ground.reset();
	if (frame.rocks) balance(frame);
	if (!mayKeep(frame, out)) return;
	for (std::size_t i = 0; i < m_slots.size(); ++i)
		if (std::uint32_t(m_slots[i].count) != clusters.count(i)) return;
	const btCollisionObject *a = frame.a->getCollisionObject(), *b = frame.b->getCollisionObject();
	m_ground = Ground{a,
					  b,
					  a->getWorldTransform(),
					  b->getWorldTransform(),
					  childOf(*frame.a),
					  childOf(*frame.b),
					  frame.aIsFirst,
					  frame.worldFromA,
					  frame.scale,
					  frame.breakingThreshold};
}

// What Bullet's iterations would end at, if there were enough of them, as the impulses that they start from: the share
// that Bullet takes of them is closedShare's counterpart. Not of a body that slides: Bullet starts friction from nothing,
// so that loads shift while it grows, and leaves friction on points whose load has gone: more than mu N in sum.
void ManifoldSet::balance(const WorldFrame& frame)
{
	const btCollisionObject &objectA = *frame.a->getCollisionObject(), &objectB = *frame.b->getCollisionObject();
	const bool aMoves = !objectA.isStaticOrKinematicObject();
	const btRigidBody* body = btRigidBody::upcast(aMoves ? &objectA : &objectB);
	if (m_shared || !body || !(aMoves ? objectB : objectA).isStaticOrKinematicObject()) return;  // a link gives way
	if (!(frame.timeStep > 0 && frame.closedShare < 1) || body->getLinearFactor() != btVector3(1, 1, 1)) return;
	const RelativeMotion other = worldMotion(aMoves ? objectB : objectA, frame.timeStep);
	const PairBody moving = pairBody(*body, Transform(), 1, worldMotion(*body, frame.timeStep), {});
	BodyBalance& balance = scratch().balance;
	balance.start(moving);
	const auto forEachPoint = [&](const auto& each)
	{
		for (std::size_t i = 0; i < m_slots.size(); ++i)
			for (int k = 0; k < std::min(m_slots[i].count, m_manifolds[i]->getNumContacts()); ++k)
				each(m_manifolds[i]->getContactPoint(k), m_manifolds[i]->getBody0() == body);
	};
	bool isRigid = true;  // springs have a law of their own
	forEachPoint(
		[&](const btManifoldPoint& point, bool isFirst)
		{
			isRigid = isRigid && (point.m_contactPointFlags & BT_CONTACT_FLAG_CONTACT_STIFFNESS_DAMPING) == 0;
			const Vec3 normal = toVec3(point.m_normalWorldOnB),
					   place = toVec3(isFirst ? point.m_positionWorldOnA : point.m_positionWorldOnB);
			balance.add({place, isFirst ? normal : -normal, other.velocity(place), speedOf(point, frame.timeStep),
						 double(point.m_combinedFriction), double(point.m_appliedImpulse)});
		});
	if (!isRigid || balance.slidesFast() || !balance.solve() || balance.slides()) return;
	std::size_t at = 0;
	forEachPoint([&](btManifoldPoint& point, bool)
				 { point.m_appliedImpulse = btScalar(balance.contact(at++).impulse / (1 - frame.closedShare)); });
}
}  // namespace clod
