// Strangers who attack a server by HTTP/2 while a soak loads it.
#pragma once

#include <string>
#include <thread>

namespace curvd {

// One attack of http2_attacks.py after the other, until destroyed. Ends this program if one cannot be started, or is
// not over after a minute.
class SoakStrangers {
 public:
  // `attacks`: the path of http2_attacks.py; none, if it is empty. `address`: where curvd serves.
  SoakStrangers(std::string attacks, std::string address);

 private:
  void Run(const std::stop_token& stop) const;

  const std::string attacks_;
  const std::string address_;
  std::jthread thread_;  // last: it uses the others
};

}  // namespace curvd
