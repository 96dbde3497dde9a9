#include "runtime/stoppable_calls.h"

#include <gtest/gtest.h>

#include <chrono>
#include <future>
#include <memory>
#include <string>
#include <thread>

namespace hapton {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

TEST(StoppableCalls, GiveWhatTheFunctionReturns) {
  StoppableCalls calls;
  EXPECT_EQ(calls.call([] { return 3; }), 3);
  EXPECT_EQ(calls.call([text = std::string("a")] { return text + "b"; }), "ab");
}

TEST(StoppableCalls, RunInAnotherThread) {
  StoppableCalls calls;
  EXPECT_NE(calls.call([] { return std::this_thread::get_id(); }), std::this_thread::get_id());
}

// The function ends long after call() has returned, and even after the object has been destroyed.
TEST(StoppableCalls, AreLeftAtTheStop) {
  std::promise<void> release;
  std::promise<void> begun;
  std::promise<void> ended;
  {
    StoppableCalls calls;
    std::thread stopper([&] {
      begun.get_future().wait();
      calls.stop();
    });
    const auto result = calls.call([&, may_end = release.get_future().share()] {
      begun.set_value();
      may_end.wait();
      ended.set_value();
      return 1;
    });
    EXPECT_FALSE(result);
    stopper.join();
    EXPECT_FALSE(calls.call([] { return 2; })) << "and so are all later ones";
  }
  release.set_value();
  EXPECT_EQ(ended.get_future().wait_for(std::chrono::seconds(60)), std::future_status::ready);
}

TEST(StoppableCalls, ASleepEndsByItselfOrAtTheStop) {
  StoppableCalls calls;
  EXPECT_TRUE(calls.sleep(milliseconds(1)));
  std::thread stopper([&] { calls.stop(); });
  const auto begin = steady_clock::now();
  EXPECT_FALSE(calls.sleep(milliseconds(60'000)));
  EXPECT_LT(steady_clock::now() - begin, milliseconds(30'000));
  stopper.join();
}

TEST(StoppableCalls, ACallAfterTheStopIsNotBegun) {
  StoppableCalls calls;
  calls.stop();
  std::promise<void> begun;
  std::future<void> begun_future = begun.get_future();
  EXPECT_FALSE(calls.call([begun = std::make_shared<std::promise<void>>(std::move(begun))] {
    begun->set_value();
    return 1;
  }));
  // The function was destroyed without having been called.
  ASSERT_EQ(begun_future.wait_for(std::chrono::seconds(60)), std::future_status::ready);
  EXPECT_THROW(begun_future.get(), std::future_error);
}

}  // namespace
}  // namespace hapton
