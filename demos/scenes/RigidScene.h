// SPDX-License-Identifier: Zlib
// Runs any scene definition in a Bullet world, of btClodShapes or of what SceneSettings::shapes says.
#pragma once
#include <memory>

#include "demos/scenes/SceneDefinition.h"

class btRigidBody;

namespace clod::demo
{
class RigidScene : public Scene
{
public:
	// Throws std::runtime_error where the plugin cannot register.
	RigidScene(const SceneDefinition& definition, const SceneSettings& settings);
	~RigidScene() override;
	void step() override;
	void place(const SceneState& state) override;
	void setMetric(const ContactMetric& metric) override;
	SceneState state() const override;
	StepTimes lastTimes() const override;
	std::vector<SceneConstant> constants() const override;

private:
	struct Bullet;
	const Hierarchy& hierarchyOf(std::size_t body) const;
	Pose poseOf(std::size_t body) const;
	void placeCamera();
	void placeGravity();
	void setUpSolver();
	void addBody(std::size_t index);
	void addJoint(btRigidBody& body, const BodyJoint& joint);
	std::vector<BodyPair> nearPairs() const;
	void addPoints(SceneState& state) const;
	void addEnergy(SceneState& state) const;
	void addAnswers(SceneState& state) const;

	SceneDefinition m_definition;
	SceneSettings m_settings;
	std::unique_ptr<Bullet> m_bullet;
	int m_step = 0;
	double m_stepMicroseconds = 0;
};
}  // namespace clod::demo
