// SPDX-License-Identifier: Zlib
// The scene spoon-cup: body A is the cup, which stands still; body B the spoon.
#pragma once
#include <memory>

#include "demos/scenes/Scene.h"

namespace clod::demo
{
class SpoonCup : public Scene
{
public:
	explicit SpoonCup(const SceneSettings& settings);
	~SpoonCup() override;
	void step() override;
	SceneState state() const override;
	std::vector<SceneConstant> constants() const override;

private:
	struct Bullet;
	void addBody(int index, const std::shared_ptr<const Hierarchy>& hierarchy, double mass, const Pose& start);
	void addPoints(SceneState& state) const;

	SceneSettings m_settings;
	std::unique_ptr<Bullet> m_bullet;
	int m_step = 0;
	double m_stepMicroseconds = 0;
};

SceneInfo spoonCupInfo();
}  // namespace clod::demo
