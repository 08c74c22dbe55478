#include "server/access/tls_identity.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "absl/time/clock.h"
#include "tests/certificates.h"

namespace curvd {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

class TlsIdentityTest : public ::testing::Test {
 protected:
  void Refused(const std::string& certificate, const std::string& key, const std::string& authorities,
               const std::string& what) {
    const auto identity = MakeTlsIdentity(certificate, key, authorities);
    EXPECT_EQ(identity.status().code(), absl::StatusCode::kInvalidArgument);
    EXPECT_THAT(std::string(identity.status().message()), HasSubstr(what));
    EXPECT_THAT(std::string(identity.status().message()), Not(HasSubstr("BEGIN")));
  }

  const TestCertificates certificates_;
  const PemPair server_ = certificates_.Issue("localhost");
};

TEST_F(TlsIdentityTest, TakesWhatFitsTogether) {
  const auto identity = MakeTlsIdentity(server_.certificate, server_.key, certificates_.authority());
  ASSERT_TRUE(identity.ok()) << identity.status();
  EXPECT_GT(identity->expires, absl::Now());
  EXPECT_LT(identity->expires, absl::Now() + absl::Hours(24 * 3));
  EXPECT_TRUE(MakeTlsIdentity(server_.certificate, server_.key, "").ok());
}

TEST_F(TlsIdentityTest, SaysWhichTextIsWrong) {
  Refused("", server_.key, "", "no PEM certificate");
  Refused(server_.certificate.substr(0, server_.certificate.size() / 2), server_.key, "", "no PEM certificate");
  Refused(server_.certificate, "", "", "private key");
  Refused(server_.certificate, server_.key.substr(0, server_.key.size() / 2), "", "private key");
  Refused(server_.certificate, certificates_.Issue("other").key, "", "not that of the certificate");
  Refused(server_.certificate, server_.key, "no certificate", "authorities");
}

}  // namespace
}  // namespace curvd
