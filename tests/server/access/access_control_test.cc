#include "server/access/access_control.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "server/rpc/error_reasons.h"
#include "tests/server/status_matchers.h"

namespace curvd {
namespace {

std::vector<AccessEntry> Tokens(const std::string& limits = "") {
  return *ParseTokenFile(absl::StrCat("alice ", FormatHash(HashToken("secret")), " ", limits));
}

std::vector<AccessEntry> Names(const std::string& text) { return *ParseNameFile(text); }

PresentedCredentials Bearer(const std::string& authorization) {
  PresentedCredentials presented;
  presented.authorization = authorization;
  presented.peer = "ipv4:10.0.0.7:1234";
  return presented;
}

PresentedCredentials Certificate(std::vector<std::string> names) {
  PresentedCredentials presented;
  presented.certificate_names = std::move(names);
  presented.peer = "ipv4:10.0.0.7:1234";
  return presented;
}

TEST(AccessControlTest, WithoutListsAnybodyMayCall) {
  const AccessControl access;
  EXPECT_EQ(access.Identify(Bearer("Bearer whatever"))->name, "10.0.0.7");
  EXPECT_EQ(access.Identify(Certificate({"scanner-7", "scanner-7.example.com"}))->name, "scanner-7");
}

TEST(AccessControlTest, ATokenLetsItsOwnerIn) {
  AccessControl access;
  access.SetTokens(Tokens("max-streams=2 max-points=1000"));
  const auto caller = access.Identify(Bearer("bearer  secret "));
  ASSERT_TRUE(caller.ok()) << caller.status();
  EXPECT_EQ(caller->name, "alice");
  EXPECT_EQ(caller->max_streams, 2u);
  EXPECT_EQ(caller->max_points, 1000u);
}

TEST(AccessControlTest, WithoutATokenTheCallersLearnsWhatToSend) {
  AccessControl access;
  access.SetTokens(Tokens());
  for (const PresentedCredentials& presented : {PresentedCredentials(), Bearer(""), Bearer("Basic secret")}) {
    EXPECT_TRUE(IsError(access.Identify(presented).status(), absl::StatusCode::kUnauthenticated, kReasonTokenMissing,
                        {"authorization: Bearer"}));
  }
}

TEST(AccessControlTest, AWrongTokenIsRefusedAndNotRepeated) {
  AccessControl access;
  access.SetTokens(Tokens());
  const absl::Status status = access.Identify(Bearer("Bearer guess-42")).status();
  EXPECT_TRUE(IsError(status, absl::StatusCode::kUnauthenticated, kReasonTokenInvalid, {"bearer token"}));
  EXPECT_EQ(status.ToString().find("guess-42"), std::string::npos);
}

TEST(AccessControlTest, ACertificateNeedsANameOfTheList) {
  AccessControl access;
  access.SetCertificateNames(Names("scanner-7.example.com max-points=5\n"));
  EXPECT_EQ(access.Identify(Certificate({"CN of it", "scanner-7.example.com"}))->max_points, 5u);
  EXPECT_TRUE(IsError(access.Identify(Certificate({"scanner-8", "b.example.com"})).status(),
                      absl::StatusCode::kPermissionDenied, kReasonClientNotAllowed, {"scanner-8, b.example.com"}));
  EXPECT_TRUE(IsError(access.Identify(Certificate({})).status(), absl::StatusCode::kPermissionDenied,
                      kReasonClientNotAllowed, {"nobody"}));
}

TEST(AccessControlTest, ARefusalShowsWholeNamesAndSaysWhatItLeavesOut) {
  AccessControl access;
  access.SetCertificateNames(Names("scanner-7"));
  const std::string long_name(400, 'a'), second(100, 'b'), third(200, 'c');
  EXPECT_TRUE(IsError(access.Identify(Certificate({long_name, second})).status(), absl::StatusCode::kPermissionDenied,
                      kReasonClientNotAllowed, {absl::StrCat(long_name, ", ", second, ";")}));
  const absl::Status cut = access.Identify(Certificate({long_name, second, third})).status();
  EXPECT_TRUE(IsError(cut, absl::StatusCode::kPermissionDenied, kReasonClientNotAllowed,
                      {absl::StrCat(long_name, ", ", second, "... (512 of 704 bytes at most are shown, of 3 names)")}));
  const absl::Status one = access.Identify(Certificate({std::string(60'000, 'd')})).status();
  EXPECT_TRUE(IsError(one, absl::StatusCode::kPermissionDenied, kReasonClientNotAllowed,
                      {absl::StrCat(std::string(512, 'd'), "... (512 of 60000 bytes")}));
  EXPECT_LT(one.ToString().size(), 3'000u);
}

TEST(AccessControlTest, WithBothListsACallNeedsBothAndTheTighterLimit) {
  AccessControl access;
  access.SetTokens(Tokens("max-points=1000"));
  access.SetCertificateNames(Names("scanner-7 max-points=5 max-streams=3"));
  PresentedCredentials presented = Certificate({"scanner-7"});
  EXPECT_EQ(access.Identify(presented).status().code(), absl::StatusCode::kUnauthenticated);
  presented.authorization = "Bearer secret";
  const auto caller = access.Identify(presented);
  ASSERT_TRUE(caller.ok());
  EXPECT_EQ(caller->name, "alice");
  EXPECT_EQ(caller->max_points, 5u);
  EXPECT_EQ(caller->max_streams, 3u);
  presented.certificate_names = {"scanner-8"};
  EXPECT_EQ(access.Identify(presented).status().code(), absl::StatusCode::kPermissionDenied);
}

TEST(AccessControlTest, RecheckFindsWhoWasTakenOffAList) {
  AccessControl access;
  access.SetTokens(Tokens());
  const Caller alice = *access.Identify(Bearer("Bearer secret"));
  EXPECT_TRUE(access.Recheck(alice).ok());
  access.SetTokens({});
  EXPECT_TRUE(IsError(access.Recheck(alice), absl::StatusCode::kUnauthenticated, kReasonTokenInvalid, {}));

  AccessControl by_name;
  by_name.SetCertificateNames(Names("scanner-7"));
  const Caller scanner = *by_name.Identify(Certificate({"CN", "scanner-7"}));
  EXPECT_TRUE(by_name.Recheck(scanner).ok());
  by_name.SetCertificateNames(Names("scanner-8"));
  EXPECT_TRUE(
      IsError(by_name.Recheck(scanner), absl::StatusCode::kPermissionDenied, kReasonClientNotAllowed, {"scanner-7"}));
}

}  // namespace
}  // namespace curvd
