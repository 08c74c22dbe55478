#include "server/host/thread_stacks.h"

#include <gtest/gtest.h>
#include <pthread.h>

#include <cstddef>
#include <thread>

namespace curvd {
namespace {

size_t StackBytesOfANewThread() {
  size_t bytes = 0;
  std::thread([&bytes] {
    pthread_attr_t attributes;
    if (pthread_getattr_np(pthread_self(), &attributes) != 0) return;
    pthread_attr_getstacksize(&attributes, &bytes);
    pthread_attr_destroy(&attributes);
  }).join();
  return bytes;
}

TEST(ThreadStacksTest, NewThreadsTakeTwoMebibytes) {
  LimitThreadStacks();
  EXPECT_EQ(StackBytesOfANewThread(), size_t{2} << 20);
}

}  // namespace
}  // namespace curvd
