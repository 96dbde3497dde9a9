#include "safety/reset_permission.h"

#include <gtest/gtest.h>

namespace hapton {
namespace {

TEST(ResetRight, TakesAnOperatorsKeyAndAPersonAtTheDevice) {
  for (const bool is_here : {false, true}) {
    for (const bool is_held : {false, true}) {
      const bool is_person_there = is_here || is_held;
      EXPECT_EQ(check_reset(KeyRole::operator_role, is_here, is_held), is_person_there ? ResetDecision::granted : ResetDecision::no_person);
      for (const KeyRole other : {KeyRole::master, KeyRole::haptics, KeyRole::vision, KeyRole::tool}) {
        EXPECT_EQ(check_reset(other, is_here, is_held), ResetDecision::no_right) << to_string(other);
      }
    }
  }
}

}  // namespace
}  // namespace hapton
