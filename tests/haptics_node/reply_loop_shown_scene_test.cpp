// What a haptics node logs about the scene that a vision node shows.
#include <string>
#include <vector>

#include "haptics_node/reply_loop.h"
#include "tests/haptics_node/reply_loop_stage.h"
#include "tests/support/log_of.h"
#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

class ShownSceneTest : public ReplyLoopStage {
 protected:
  void take(const Message&) override {}

  // The log of a haptics node that touches one scene, while a vision node reports that it shows these scenes, one after the other.
  std::string log_while_shown(const SceneFacts& touched, const std::vector<SceneFacts>& shown) {
    ReplyLoop loop(client_, clock_, step_, builder_, {}, false, touched);
    for (int i = 0; i < 10 && client_.state() != JoinState::joined; ++i) {
      loop.turn(clock_.now_ns() + kMs);
      receive_at_hub();
    }
    EXPECT_EQ(client_.state(), JoinState::joined);
    return log_of([&] {
      for (const SceneFacts& each : shown) {
        send(each);
        loop.turn(clock_.now_ns() + kMs);
      }
    });
  }

  static int count(const std::string& log, const std::string& words) {
    int found = 0;
    for (auto at = log.find(words); at != std::string::npos; at = log.find(words, at + 1)) ++found;
    return found;
  }

  static TouchScene shown_sheet() { return {.objects = {{made::shared(made::sheet(0.1, 0.0, 2)), {}}}}; }

  HapticsStep step_{std::make_unique<TouchStep>(*make_method({.name = "sweep"}, shown_sheet())), 1e-5};
  MethodBuilder builder_{{.name = "sweep"}, shown_sheet()};
};

SceneFacts facts_of_scene(std::uint64_t hash) { return {.given_hash = hash}; }

TEST_F(ShownSceneTest, EachOtherSceneIsWarnedOfOnce) {
  const std::string other = "vision_node shows another scene";
  EXPECT_EQ(count(log_while_shown(facts_of_scene(9), {facts_of_scene(8), facts_of_scene(8), facts_of_scene(8)}), other), 1);
  EXPECT_EQ(count(log_while_shown(facts_of_scene(9), {facts_of_scene(8), facts_of_scene(7)}), other), 2);
}

TEST_F(ShownSceneTest, TheSameSceneIsMentionedOnlyAfterAnother) {
  const std::string any = "vision_node shows";
  EXPECT_EQ(count(log_while_shown(facts_of_scene(9), {facts_of_scene(9), facts_of_scene(9)}), any), 0);
  const std::string log = log_while_shown(facts_of_scene(9), {facts_of_scene(8), facts_of_scene(9), facts_of_scene(9)});
  EXPECT_EQ(count(log, "vision_node shows the same scene again"), 1) << log;
  EXPECT_EQ(count(log, any), 2) << log;
}

TEST_F(ShownSceneTest, NothingIsLoggedWhereOneOfThemIsNotKnown) {
  EXPECT_EQ(count(log_while_shown(facts_of_scene(9), {facts_of_scene(0)}), "vision_node"), 0);
  EXPECT_EQ(count(log_while_shown(facts_of_scene(0), {facts_of_scene(8)}), "vision_node"), 0);
}

TEST_F(ShownSceneTest, AnotherToolIsWarnedOfOnce) {
  const SceneFacts touched{.given_hash = 9, .tool_hash = SceneFacts::kNoTool};
  const SceneFacts shown{.given_hash = 9, .tool_hash = 5};
  const std::string log = log_while_shown(touched, {shown, shown, touched, touched});
  EXPECT_EQ(count(log, "a rigid tool, but the stylus is a probe here"), 1) << log;
  EXPECT_EQ(count(log, "vision_node"), 2) << log;
}

}  // namespace
}  // namespace hapton
