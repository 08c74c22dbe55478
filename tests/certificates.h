// Certificates of a test's own authority, made by the openssl program.
#pragma once

#include <string>

#include "tests/client/temp_dir.h"

namespace curvd {

struct PemPair {
  std::string certificate;
  std::string key;
};

// An authority that lives as long as a test. Failures of openssl fail the test.
class TestCertificates {
 public:
  TestCertificates();

  // The authority's own certificate, PEM.
  std::string authority() const { return dir_.Read("ca.crt"); }
  // A certificate for servers and clients with the common name `name`, and the DNS name `name` and, for "localhost",
  // the address 127.0.0.1 as alternative names. Valid since ten days ago; expired if `days_left` is below 0.
  PemPair Issue(const std::string& name, int days_left = 2) const;

 private:
  void OpenSsl(const std::string& arguments) const;

  curv::TempDir dir_;
};

}  // namespace curvd
