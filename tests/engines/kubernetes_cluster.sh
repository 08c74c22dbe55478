#!/usr/bin/env bash
# A Kubernetes of one machine, to try deploy/engines/kubernetes on: kubernetes_cluster.sh BIN FOLDER [IMAGE.tar]
# BIN holds kube-apiserver, kube-controller-manager, kube-scheduler and kubelet of Debian's source, and the image's program
# `pause`; deploy/engines/kubernetes/README.md tells how to build them. Needs root and Debian's containerd, runc, etcd-server,
# containernetworking-plugins, dnsmasq-base, iptables and buildah. All state is in FOLDER, an empty one; FOLDER/kubeconfig is for kubectl.
# IMAGE.tar is a docker archive that the node then has. Runs until it gets SIGTERM or SIGINT, and then ends all that it started.
#
# Nobody but this machine can reach it, and whoever is on this machine may do everything. It serves no names but those of headless
# services: dnsmasq stands for CoreDNS, and nothing stands for kube-proxy.
set -euo pipefail
bin=$(realpath "$1")
folder=$(realpath "$2")
image=${3:-}
port=16443 # of the API
gateway=10.89.7.1
runtime=unix://$folder/containerd.sock

run() {
  "${@:2}" >"$folder/$1.log" 2>&1 &
  echo $! >"$folder/$1.pid"
}
saved=$(sysctl -e vm.overcommit_memory vm.panic_on_oom kernel.panic kernel.panic_on_oops 2>/dev/null | tr -d ' ')
finish() {
  trap '' TERM INT
  set +e  # whatever has ended already, the rest is ended
  for name in names dnsmasq kubelet; do kill "$(cat "$folder/$name.pid")" 2>/dev/null; done
  for task in $(ctr -a "$folder/containerd.sock" -n k8s.io task ls -q 2>/dev/null); do
    ctr -a "$folder/containerd.sock" -n k8s.io task kill -s SIGKILL "$task"
  done
  for each in "$folder"/*.pid; do kill "$(cat "$each")" 2>/dev/null; done
  wait
  # What watches over containers is not a child of containerd's.
  for pid in $(pgrep -f "containerd-shim.*-address $folder/" || true); do kill -9 "$pid"; done
  awk -v from="$folder/" 'index($2, from) == 1 { print $2 }' /proc/mounts | sort -r | xargs -r umount -l
  ip link del curv-k8s
  for setting in $saved; do sysctl -qw "$setting"; done
} 2>/dev/null
trap finish EXIT
trap 'exit 0' TERM INT

# Certificates and tokens.
cd "$folder"
mkdir -p etcd kubelet state net
openssl genrsa -out accounts.key 2048 2>/dev/null
token=$(openssl rand -hex 16)
echo "$token,admin,admin,system:masters" >tokens.csv
cat >kubeconfig <<END
apiVersion: v1
kind: Config
clusters: [{name: here, cluster: {server: "https://127.0.0.1:$port", insecure-skip-tls-verify: true}}]
users: [{name: admin, user: {token: $token}}]
contexts: [{name: here, context: {cluster: here, user: admin}}]
current-context: here
END

# Containers. Who is not allowed to shield a process from the kernel's killer of processes is not asked to.
cat >net/10-curv.conflist <<END
{"cniVersion": "0.4.0", "name": "curv", "plugins": [
  {"type": "bridge", "bridge": "curv-k8s", "isGateway": true,
   "ipam": {"type": "host-local", "dataDir": "$folder/addresses", "ranges": [[{"subnet": "10.89.7.0/24", "gateway": "$gateway"}]]}}]}
END
cat >containerd.toml <<END
version = 2
root = "$folder/containerd"
state = "$folder/state"
[grpc]
  address = "$folder/containerd.sock"
[plugins."io.containerd.grpc.v1.cri"]
  sandbox_image = "localhost/pause:1"
  restrict_oom_score_adj = true
  disable_apparmor = true
  [plugins."io.containerd.grpc.v1.cri".cni]
    bin_dir = "/usr/lib/cni"
    conf_dir = "$folder/net"
END
run containerd containerd --config containerd.toml
until ctr -a containerd.sock version >/dev/null 2>&1; do sleep 0.2; done
printf 'FROM scratch\nCOPY pause /pause\nENTRYPOINT ["/pause"]\n' >Dockerfile.pause
buildah bud --quiet --isolation=chroot --format=docker --tag=localhost/pause:1 --file=Dockerfile.pause "$bin" >/dev/null
buildah push --quiet localhost/pause:1 "docker-archive:$folder/pause.tar:localhost/pause:1"
for archive in pause.tar $image; do ctr -a containerd.sock -n k8s.io images import "$archive" >/dev/null; done

# The cluster.
run etcd etcd --data-dir=etcd --listen-client-urls=http://127.0.0.1:12379 --advertise-client-urls=http://127.0.0.1:12379 \
  --listen-peer-urls=http://127.0.0.1:12380 --initial-advertise-peer-urls=http://127.0.0.1:12380 \
  --initial-cluster=default=http://127.0.0.1:12380 --unsafe-no-fsync
run apiserver "$bin/kube-apiserver" --etcd-servers=http://127.0.0.1:12379 --secure-port=$port --bind-address=127.0.0.1 \
  --cert-dir="$folder/certificates" --token-auth-file=tokens.csv --authorization-mode=AlwaysAllow --service-cluster-ip-range=10.89.8.0/24 \
  --service-account-issuer=https://curv --service-account-key-file=accounts.key --service-account-signing-key-file=accounts.key
export KUBECONFIG=$folder/kubeconfig
until kubectl get --raw /readyz >/dev/null 2>&1; do sleep 0.5; kill -0 "$(cat apiserver.pid)"; done
run controllers "$bin/kube-controller-manager" --kubeconfig=kubeconfig --service-account-private-key-file=accounts.key \
  --leader-elect=false --port=0 --cert-dir="$folder/certificates"
run scheduler "$bin/kube-scheduler" --kubeconfig=kubeconfig --leader-elect=false --port=0 --cert-dir="$folder/certificates"
cat >kubelet.yaml <<END
apiVersion: kubelet.config.k8s.io/v1beta1
kind: KubeletConfiguration
address: 127.0.0.1
authentication: {anonymous: {enabled: true}, webhook: {enabled: false}}
authorization: {mode: AlwaysAllow}
cgroupDriver: cgroupfs
clusterDNS: [$gateway]
clusterDomain: cluster.local
oomScoreAdj: 0
makeIPTablesUtilChains: false
failSwapOn: false
resolvConf: /etc/resolv.conf
evictionHard: {memory.available: 100Mi}
END
run kubelet "$bin/kubelet" --config=kubelet.yaml --kubeconfig=kubeconfig --root-dir="$folder/kubelet" --cert-dir="$folder/certificates" \
  --container-runtime=remote --container-runtime-endpoint="$runtime" --hostname-override=here

# Names of headless services: those of their endpoints that are ready.
run names bash -c 'while sleep 0.5; do
  kubectl get endpoints -o jsonpath="{range .items[*]}{.metadata.name}{range .subsets[*].addresses[*]} {.ip}{end}{\"\n\"}{end}" |
    while read -r name addresses; do for each in $addresses; do echo "$each $name.default.svc.cluster.local"; done; done >names.new
  cmp -s names.new names.now || { cp names.new names.now; kill -HUP "$(cat dnsmasq.pid)"; }
done'
touch names.now
until ip link show curv-k8s >/dev/null 2>&1; do
  ip link add curv-k8s type bridge && ip address add $gateway/24 dev curv-k8s && ip link set curv-k8s up
done
run dnsmasq dnsmasq --keep-in-foreground --user=root --conf-file=/dev/null --no-resolv --no-hosts --addn-hosts="$folder/names.now" \
  --listen-address=$gateway --bind-interfaces --local-ttl=1 --log-facility=-

until kubectl get node here 2>/dev/null | grep -qw Ready; do sleep 0.5; kill -0 "$(cat kubelet.pid)"; done
echo "ready: export KUBECONFIG=$folder/kubeconfig"
sleep infinity &
wait $!
