// Reservations of tests, and the answers that they get.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <functional>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/admission/memory_budget.h"

namespace curvd {

// Keeps the answer that a reservation gets.
struct GrantAnswer {
  std::function<void(absl::Status)> callback() {
    return [this](absl::Status answer) {
      ++count;
      status = std::move(answer);
    };
  }
  int count = 0;
  absl::Status status;
};

inline void MustNotAnswer(const absl::Status& status) { FAIL() << "unexpected answer: " << status; }

inline bool GrantsNow(MemoryBudget::Reservation& reservation, uint64_t bytes) {
  const absl::StatusOr<bool> granted = reservation.GrowTo(bytes, MustNotAnswer);
  return granted.ok() && *granted;
}

inline bool Waits(MemoryBudget::Reservation& reservation, uint64_t bytes, GrantAnswer& answer) {
  const absl::StatusOr<bool> granted = reservation.GrowTo(bytes, answer.callback());
  return granted.ok() && !*granted;
}

}  // namespace curvd
