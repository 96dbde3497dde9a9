#include "link/agreement_worker.h"

#include <gtest/gtest.h>
#include <pthread.h>

#include <thread>
#include <vector>

#include "tests/support/allocation_guard.h"

namespace hapton {
namespace {

using Where = AgreementWorker::Where;

AgreementTask request_task(std::uint32_t number) {
  EXPECT_TRUE(seal::start_crypto());
  AgreementTask task;
  task.number = number;
  task.psk.fill(3);
  return task;
}

void take_all(AgreementWorker& worker, std::vector<AgreementTask>& tasks, std::size_t count) {
  for (AgreementTask task; tasks.size() < count;) {
    if (worker.take(task)) tasks.push_back(task);
  }
}

class AgreementWorkers : public testing::TestWithParam<Where> {};
INSTANTIATE_TEST_SUITE_P(Each, AgreementWorkers, testing::Values(Where::caller, Where::own_thread));

TEST_P(AgreementWorkers, FinishTasksInOrder) {
  AgreementWorker worker(GetParam());
  std::vector<AgreementTask> tasks;
  for (std::uint32_t n = 0; n < AgreementWorker::kCapacity; ++n) ASSERT_TRUE(worker.submit(request_task(n)));
  take_all(worker, tasks, AgreementWorker::kCapacity);
  for (std::uint32_t n = 0; n < tasks.size(); ++n) {
    EXPECT_EQ(tasks[n].number, n);
    EXPECT_TRUE(tasks[n].is_valid);
    EXPECT_EQ(tasks[n].psk, seal::Secret{}) << "the key is still in it";
  }
  EXPECT_EQ(worker.pending_count(), 0U);
}

TEST_P(AgreementWorkers, TakeNoMoreThanTheyHaveRoomFor) {
  AgreementWorker worker(GetParam());
  for (int round = 0; round < 3; ++round) {
    std::size_t accepted = 0;
    while (worker.submit(request_task(0))) ++accepted;
    EXPECT_EQ(accepted, AgreementWorker::kCapacity);
    std::vector<AgreementTask> tasks;
    take_all(worker, tasks, accepted);
  }
}

// The destructor neither waits for ever nor leaves a thread that is still joinable, which would end the program.
TEST_P(AgreementWorkers, EndWithWorkLeft) {
  AgreementWorker worker(GetParam());
  for (int n = 0; n < 10; ++n) EXPECT_TRUE(worker.submit(request_task(0)));
  std::vector<AgreementTask> tasks;
  take_all(worker, tasks, 1);
  EXPECT_EQ(worker.pending_count(), 9U) << "work is left, and the thread has begun";
}

TEST_P(AgreementWorkers, AgreeOnOneSession) {
  AgreementWorker node(GetParam());
  AgreementWorker hub(GetParam());
  std::vector<AgreementTask> finished;
  node.submit(request_task(1));
  take_all(node, finished, 1);
  AgreementTask reply = request_task(2);
  reply.kind = AgreementTask::Kind::reply_to_request;
  reply.connection = 1234;
  reply.first = finished[0].first;
  hub.submit(reply);
  take_all(hub, finished, 2);
  ASSERT_TRUE(finished[1].is_valid);
  AgreementTask read_task = finished[0];
  read_task.kind = AgreementTask::Kind::read_reply;
  read_task.second = finished[1].second;
  node.submit(read_task);
  take_all(node, finished, 3);
  ASSERT_TRUE(finished[2].is_valid);
  EXPECT_EQ(finished[2].connection, 1234U);
  EXPECT_EQ(finished[1].keys.client_to_hub, finished[2].keys.client_to_hub);
  EXPECT_EQ(finished[1].keys.hub_to_client, finished[2].keys.hub_to_client);
  EXPECT_NE(finished[1].keys.client_to_hub, finished[1].keys.hub_to_client);
}

TEST(AgreementWorkerTest, HandsOverWithoutTheHeap) {
  if (!AllocationGuard::is_available()) GTEST_SKIP() << "heap use cannot be counted in this build";
  AgreementWorker worker(Where::own_thread);
  const AgreementTask task = request_task(0);
  const AllocationGuard guard;
  AgreementTask done;
  for (int n = 0; n < 50; ++n) {
    ASSERT_TRUE(worker.submit(task));
    while (!worker.take(done)) std::this_thread::yield();
  }
  EXPECT_EQ(guard.count(), 0U);
}

}  // namespace
}  // namespace hapton
