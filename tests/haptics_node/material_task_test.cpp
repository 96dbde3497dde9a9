#include "haptics_node/material_task.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>

#include "scene/scene_file.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/log_of.h"
#include "tests/support/made_meshes.h"
#include "tests/support/patience.h"

namespace hapton {
namespace {

Scene hull_and_deck() {
  Scene scene;
  for (const char* name : {"hull", "deck"}) {
    scene.objects.push_back({.name = name, .mesh = made::shared(made::sheet(0.1, 0.0, 2)), .material = {}});
  }
  return scene;
}

MaterialRequest stiffness_request(std::uint32_t number, std::string_view object, double n_per_m) {
  MaterialRequest made{.request = number, .change = {.fields = MaterialChange::kStiffness, .stiffness_n_per_m = n_per_m}};
  std::copy(object.begin(), object.end(), made.object.begin());
  return made;
}

std::unique_ptr<TunedMaterials> wait_for_result(MaterialTask& material_task) {
  for (int i = 0; i < 3000; ++i) {
    if (auto result = material_task.take()) return result;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return nullptr;
}

TEST(MaterialTask, GivesTheMaterialsOfAllObjectsAndNotifiesItsListener) {
  std::mutex mutex;
  std::vector<double> notified;
  MaterialTask material_task(hull_and_deck(), 0.0, [&](const std::vector<Material>& materials) {
    const std::scoped_lock lock(mutex);
    for (const Material& material : materials) notified.push_back(material.stiffness_n_per_m);
  });
  EXPECT_EQ(material_task.take(), nullptr);
  material_task.request(stiffness_request(5, "deck", 700.0));
  const auto result = wait_for_result(material_task);
  ASSERT_NE(result, nullptr);
  ASSERT_EQ(result->materials.size(), 2U);
  EXPECT_EQ(result->materials[0].stiffness_n_per_m, 1000.0);
  EXPECT_EQ(result->materials[1].stiffness_n_per_m, 700.0);
  EXPECT_EQ(result->state.request, 5U);
  EXPECT_EQ(result->state.object_count, 1U);
  // The listener is notified after take() has the result, so the loop does not wait for it.
  const auto notified_now = [&] {
    const std::scoped_lock lock(mutex);
    return notified;
  };
  ASSERT_TRUE(wait_until([&] { return !notified_now().empty(); }));
  EXPECT_EQ(notified_now(), (std::vector{1000.0, 700.0}));
}

TEST(MaterialTask, GivesTheToolMaterialsOfARigidTool) {
  Scene scene = hull_and_deck();
  scene.objects[0].effects.viscosity.damping_ns_per_m = 3.0;
  const auto describe = [](double n_per_m) {
    HapticsSetup::Text text = {'t'};
    text[1] = n_per_m == 900.0 ? '9' : '?';
    return text;
  };
  MaterialTask material_task(scene, 900.0, {}, describe);
  MaterialRequest request = stiffness_request(5, "deck", 2000.0);
  request.change.fields |= MaterialChange::kDamping | MaterialChange::kFrictionStatic | MaterialChange::kFrictionDynamic;
  request.change.damping_ns_per_m = 2.0;
  request.change.friction_static = 0.5;
  request.change.friction_dynamic = 0.4;
  material_task.request(request);
  auto result = wait_for_result(material_task);
  ASSERT_NE(result, nullptr);
  ASSERT_TRUE(result->tool_materials);
  EXPECT_LT(result->tool_materials->stiffness_n_per_m, 900.0) << "coupled, as at the start";
  EXPECT_GT(result->tool_materials->stiffness_n_per_m, 500.0);
  ASSERT_EQ(result->tool_materials->friction.size(), 2U);
  EXPECT_EQ(result->tool_materials->friction[0].friction_static, 0.0);
  EXPECT_EQ(result->tool_materials->friction[1].friction_static, 0.5);
  EXPECT_EQ(result->tool_materials->friction[1].friction_dynamic, 0.4);
  EXPECT_EQ(result->tool_materials->damping[0].along_ns_per_m, 3.0);
  EXPECT_GT(result->tool_materials->damping[1].normal_ns_per_m, 0.0);
  EXPECT_EQ(result->tool_method[0], 't');
  material_task.retire(std::move(result));
  MaterialTask without_tool(hull_and_deck(), 0.0);
  without_tool.request(stiffness_request(6, "deck", 700.0));
  result = wait_for_result(without_tool);
  ASSERT_NE(result, nullptr);
  EXPECT_FALSE(result->tool_materials);
}

TEST(MaterialTask, ARejectedRequestHasNoMaterials) {
  bool was_notified = false;
  MaterialTask material_task(hull_and_deck(), 0.0, [&](const std::vector<Material>&) { was_notified = true; });
  material_task.request(stiffness_request(6, "dek", 700.0));
  const auto result = wait_for_result(material_task);
  ASSERT_NE(result, nullptr);
  EXPECT_TRUE(result->materials.empty());
  EXPECT_EQ(result->state.request, 6U);
  EXPECT_STREQ(result->state.rejection.data(), "the scene has no object 'dek'; did you mean 'deck'?");
  EXPECT_FALSE(was_notified);
}

TEST(MaterialTask, TheOutcomeOfARequestIsLogged) {
  const auto log_after = [](std::string_view object) {
    return log_of([&] {
      MaterialTask material_task(hull_and_deck(), 0.0);
      material_task.request(stiffness_request(6, object, 700.0));
      EXPECT_NE(wait_for_result(material_task), nullptr);
    });
  };
  EXPECT_NE(log_after("deck").find("object 'deck': stiffness 700 N/m"), std::string::npos);
  EXPECT_NE(log_after("dek").find("the scene has no object 'dek'; did you mean 'deck'?; no material is changed"), std::string::npos);
}

// An accepted change that nobody has taken yet is not replaced by the result of the next request.
TEST(MaterialTask, NoResultIsLost) {
  std::atomic<bool> is_computed = false;
  MaterialTask material_task(hull_and_deck(), 0.0, [&](const std::vector<Material>&) { is_computed = true; });
  material_task.request(stiffness_request(1, "hull", 700.0));
  ASSERT_TRUE(wait_until([&] { return is_computed.load(); })) << "a later request replaces one that has not started";
  material_task.request(stiffness_request(2, "nobody", 800.0));
  std::this_thread::sleep_for(std::chrono::milliseconds(100));  // time for several polls of the task
  auto first = wait_for_result(material_task);
  ASSERT_NE(first, nullptr);
  EXPECT_EQ(first->state.request, 1U);
  EXPECT_FALSE(first->materials.empty());
  material_task.retire(std::move(first));
  const auto second = wait_for_result(material_task);
  ASSERT_NE(second, nullptr);
  EXPECT_EQ(second->state.request, 2U);
  EXPECT_EQ(second->state.object_count, 1U) << "the first is still in use";
}

// The scene file is read again while a change is computed. By index, the materials of that change would go to other objects.
TEST(MaterialTask, AChangeOfASceneThatIsReplacedMeanwhileNotifiesNobody) {
  std::atomic<MaterialTask*> task = nullptr;
  std::mutex mutex;
  std::vector<double> notified;
  const auto listener = [&](const std::vector<Material>& materials) {
    const std::scoped_lock lock(mutex);
    notified.push_back(materials[1].stiffness_n_per_m);
  };
  const auto replace_scene = [&](double) {
    if (MaterialTask* const once = task.exchange(nullptr)) once->follow(hull_and_deck(), 1);
    return HapticsSetup::Text();
  };
  MaterialTask material_task(hull_and_deck(), 0.0, listener, replace_scene);
  task = &material_task;
  for (const std::uint32_t number : {1U, 2U}) {
    material_task.request(stiffness_request(number, "deck", 700.0 + number));
    auto result = wait_for_result(material_task);
    ASSERT_NE(result, nullptr);
    EXPECT_EQ(result->scene_revision, number - 1);
    material_task.retire(std::move(result));
  }
  const auto notified_now = [&] {
    const std::scoped_lock lock(mutex);
    return notified;
  };
  ASSERT_TRUE(wait_until([&] { return !notified_now().empty(); }));
  EXPECT_EQ(notified_now(), std::vector{702.0});
}

TEST(MaterialTask, TheReplyLoopsCallsFreeNothing) {
  if (!AllocationGuard::is_available()) GTEST_SKIP() << "heap use cannot be counted in this build";
  MaterialTask material_task(hull_and_deck(), 0.0);
  const MaterialRequest request = stiffness_request(1, "hull", 700.0);
  const AllocationGuard guard;
  for (int i = 0; i < 100; ++i) {
    material_task.request(request);
    if (auto result = material_task.take()) material_task.retire(std::move(result));
  }
  EXPECT_EQ(guard.count(), 0U);
}

}  // namespace
}  // namespace hapton
