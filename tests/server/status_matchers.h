// What a test asks of an error: code, reason, and that the message names what a person must know.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "absl/status/status.h"
#include "absl/strings/cord.h"
#include "absl/strings/str_cat.h"
#include "google/rpc/error_details.pb.h"
#include "server/rpc/error_detail.h"

namespace curvd {

inline ::testing::AssertionResult IsError(const absl::Status& status, absl::StatusCode code, const std::string& reason,
                                          std::initializer_list<std::string> words) {
  if (status.code() != code || ReasonOf(status) != reason) {
    return ::testing::AssertionFailure() << status.ToString() << " is not " << absl::StatusCodeToString(code) << " "
                                         << reason;
  }
  for (const std::string& word : words) {
    if (std::string(status.message()).find(word) == std::string::npos) {
      return ::testing::AssertionFailure() << '"' << status.message() << "\" does not name " << word;
    }
  }
  return ::testing::AssertionSuccess();
}

// The entry of the ErrorInfo's metadata; empty where there is none.
inline std::string MetadataOf(const absl::Status& status, const std::string& key) {
  google::rpc::ErrorInfo info;
  const auto payload = status.GetPayload("type.googleapis.com/google.rpc.ErrorInfo");
  if (payload.has_value()) info.ParseFromString(std::string(*payload));
  const auto found = info.metadata().find(key);
  return found == info.metadata().end() ? "" : found->second;
}

}  // namespace curvd
