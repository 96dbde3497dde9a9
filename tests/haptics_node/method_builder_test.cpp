#include "haptics_node/method_builder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <string>
#include <string_view>
#include <thread>
#include <utility>

#include "tests/support/made_meshes.h"
#include "tests/support/patience.h"

namespace hapton {
namespace {

TouchScene one_sphere() { return {.objects = {{made::shared(made::sphere(0.05, 8)), {}}}}; }

MethodBuilder::MethodName name_of(std::string_view text) {
  MethodBuilder::MethodName name = {};
  std::copy(text.begin(), text.end(), name.begin());
  return name;
}

std::unique_ptr<BuiltMethod> wait_for_method(MethodBuilder& builder) {
  for (int i = 0; i < 3000; ++i) {
    if (auto built = builder.take()) {
      return built;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return nullptr;
}

const RejectedMethod* wait_for_rejection(MethodBuilder& builder) {
  for (int i = 0; i < 3000; ++i) {
    if (const RejectedMethod* rejected = builder.take_rejection()) return rejected;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return nullptr;
}

TEST(MethodBuilder, BuildsEveryRequestedMethod) {
  MethodBuilder builder({}, one_sphere());
  EXPECT_EQ(builder.take(), nullptr);
  for (int i = 0; i < 3; ++i) {
    builder.request(name_of("sweep"));
    auto built = wait_for_method(builder);
    ASSERT_NE(built, nullptr);
    EXPECT_NE(built->step->method().describe().find("sweep"), std::string::npos);
    builder.retire(std::move(built));
  }
}

TEST(MethodBuilder, AnImpossibleMethodIsReportedWithItsReasonAndBuildsNothing) {
  MethodBuilder builder({.probe_radius_m = 0.001}, one_sphere());
  EXPECT_EQ(builder.take_rejection(), nullptr);
  std::uint32_t request_id = 6;
  for (const auto& [name, reason] : {std::pair("sixteen letters!", "'sixteen letters!' is not known"), std::pair("sweep", "radius")}) {
    builder.request(name_of(name), ++request_id);
    const RejectedMethod* rejected = wait_for_rejection(builder);
    ASSERT_NE(rejected, nullptr);
    EXPECT_EQ(rejected->request_id, request_id);
    EXPECT_NE(std::string_view(rejected->why.data()).find(reason), std::string_view::npos) << rejected->why.data();
    EXPECT_EQ(builder.take_rejection(), nullptr);
    EXPECT_EQ(builder.take(), nullptr);
  }
  builder.request(name_of("proxy"), 42);
  const auto built = wait_for_method(builder);
  ASSERT_NE(built, nullptr);
  EXPECT_EQ(built->request_id, 42U);
  EXPECT_EQ(builder.take_rejection(), nullptr);
}

// Waits until the builder's thread has taken a request and has nothing left to do.
bool wait_until_idle(MethodBuilder& builder) {
  const std::uint64_t before = builder.idle_polls();
  return wait_until([&] { return builder.idle_polls() >= before + 2; });
}

// Without the scene, the node would not know that scene; without the request, its sender would wait for the reply.
TEST(MethodBuilder, WhatReplacesAMethodThatWasNotTakenKeepsItsSceneAndItsRequest) {
  MethodBuilder builder({}, one_sphere());
  auto moved = std::make_shared<NewScene>();
  moved->touch = one_sphere();
  moved->revision = 1;
  ASSERT_TRUE(builder.rebuild_for(moved));
  builder.request(name_of("sweep"), 7);
  ASSERT_TRUE(wait_until_idle(builder));
  auto first = builder.take();
  ASSERT_NE(first, nullptr);
  EXPECT_EQ(first->request_id, 7U);
  EXPECT_EQ(first->scene.get(), moved.get());
  builder.retire(std::move(first));

  builder.request(name_of("proxy"), 8);
  ASSERT_TRUE(wait_until_idle(builder));
  auto next = std::make_shared<NewScene>(*moved);
  next->revision = 2;
  ASSERT_TRUE(builder.rebuild_for(next));
  const auto second = builder.take();
  ASSERT_NE(second, nullptr);
  EXPECT_EQ(second->request_id, 8U);
  EXPECT_EQ(second->scene.get(), next.get());
}

TEST(MethodBuilder, WhatIsRequestedAfterAnotherSceneIsBuiltForThatScene) {
  MethodBuilder builder({}, one_sphere());
  auto sheet = std::make_shared<NewScene>();
  sheet->touch = {.objects = {{made::shared(made::sheet(0.1, 0.1, 6)), {}}}};
  sheet->revision = 1;
  ASSERT_TRUE(builder.rebuild_for(sheet));
  builder.retire(builder.take());
  builder.request(name_of("sweep"), 7);
  const auto built = wait_for_method(builder);
  ASSERT_NE(built, nullptr);
  TouchInput input;
  input.p_WD = Vec3(0.01, 0.01, 0.101);
  built->step->reset(input);
  input.p_WD.z() = 0.099;
  EXPECT_GT(built->step->step(input).force_n.z(), 0.5);
}

TEST(MethodBuilder, AnotherSceneIsBuiltForTheMethodThatWasRequestedLast) {
  MethodBuilder builder({}, one_sphere());
  builder.request(name_of("sweep"), 7);
  builder.retire(wait_for_method(builder));
  auto next = std::make_shared<NewScene>();
  next->touch = one_sphere();
  next->revision = 1;
  ASSERT_TRUE(builder.rebuild_for(next));
  const auto built = wait_for_method(builder);
  ASSERT_NE(built, nullptr);
  EXPECT_TRUE(std::string_view(built->text.data()).starts_with("name=sweep")) << built->text.data();
  EXPECT_NE(built->step->method().describe().find("sweep"), std::string::npos);
}

TEST(MethodBuilder, AnUnusedMethodIsFreed) {
  TouchScene scene = one_sphere();
  const std::weak_ptr<const TriangleMesh> mesh = scene.objects[0].mesh;
  {
    MethodBuilder builder({}, std::move(scene));
    builder.request(name_of("sweep"));
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    EXPECT_FALSE(mesh.expired());
  }
  EXPECT_TRUE(mesh.expired());
}

}  // namespace
}  // namespace hapton
