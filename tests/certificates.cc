#include "tests/certificates.h"

#include <gtest/gtest.h>

#include <cstdlib>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"

namespace curvd {
namespace {

// As openssl ca takes times.
std::string DaysFromNow(int days) {
  return absl::FormatTime("%Y%m%d%H%M%SZ", absl::Now() + days * absl::Hours(24), absl::UTCTimeZone());
}

}  // namespace

TestCertificates::TestCertificates() {
  dir_.Write("index", "");
  dir_.Write("config", absl::StrCat("[ca]\ndefault_ca=authority\n[authority]\ndatabase=", dir_.File("index"),
                                    "\nnew_certs_dir=", dir_.File(""), "\nrand_serial=yes\ndefault_md=sha256\n",
                                    "unique_subject=no\npolicy=policy\n[policy]\ncommonName=supplied\n"));
  OpenSsl(absl::StrCat("req -x509 -newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes -days 2 -subj /CN=authority",
                       " -keyout ", dir_.File("ca.key"), " -out ", dir_.File("ca.crt")));
}

PemPair TestCertificates::Issue(const std::string& name, int days_left) const {
  OpenSsl(absl::StrCat("req -newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes -subj /CN=", name, " -keyout ",
                       dir_.File("key"), " -out ", dir_.File("request")));
  dir_.Write("extensions", absl::StrCat("subjectAltName=DNS:", name, name == "localhost" ? ",IP:127.0.0.1" : "", "\n"));
  OpenSsl(absl::StrCat("ca -batch -notext -config ", dir_.File("config"), " -cert ", dir_.File("ca.crt"), " -keyfile ",
                       dir_.File("ca.key"), " -in ", dir_.File("request"), " -out ", dir_.File("crt"), " -extfile ",
                       dir_.File("extensions"), " -startdate ", DaysFromNow(-10), " -enddate ",
                       DaysFromNow(days_left)));
  return {dir_.Read("crt"), dir_.Read("key")};
}

void TestCertificates::OpenSsl(const std::string& arguments) const {
  const std::string command = absl::StrCat("openssl ", arguments, " 2>", dir_.File("errors"));
  EXPECT_EQ(std::system(command.c_str()), 0) << command << "\n" << dir_.Read("errors");
}

}  // namespace curvd
