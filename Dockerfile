FROM debian:bookworm-slim AS build
RUN apt-get update -qq && apt-get install -qq --no-install-recommends make >/dev/null && rm -rf /var/lib/apt/lists/*
WORKDIR /curvd
COPY Makefile ./
RUN make build-deps
COPY . .
ARG CURVD_COMMIT
RUN make release && strip build/release/bin/curvd build/release/bin/curv

FROM debian:bookworm-slim
RUN apt-get update -qq \
    && apt-get install -qq --no-install-recommends \
      libgrpc++1.51 libprotobuf32 libabsl20220623 libhwy1 libprometheus-cpp-pull1.0 libprometheus-cpp-core1.0 libcivetweb1 \
      libspdlog1.10 libfmt9 libpng16-16 zlib1g libcairo2 libpangocairo-1.0-0 libfontconfig1 fontconfig fonts-dejavu-core liblzf1 \
      libssl3 ca-certificates >/dev/null \
    && rm -rf /var/lib/apt/lists/*
# curv can write no font cache where the root is read-only. This one holds while the folders have its times, of which
# layers keep whole seconds only.
RUN mkdir -p /usr/local/share/fonts \
    && find /usr/share/fonts /usr/local/share/fonts -type d -exec touch -d 2000-01-01 {} + \
    && fc-cache --force
COPY --from=build /curvd/build/release/bin/curvd /curvd/build/release/bin/curv /usr/local/bin/
USER 65532:65532
# Other machines can reach these: curvd starts only with --tls-cert and --tls-key, or with --insecure.
ENV CURVD_LISTEN=0.0.0.0:50061 CURVD_METRICS_LISTEN=0.0.0.0:9461 CURVD_HEALTH_LISTEN=127.0.0.1:50062
EXPOSE 50061 9461
STOPSIGNAL SIGTERM
HEALTHCHECK --interval=10s --timeout=5s --start-period=5s CMD ["curv", "info", "--health", "--server=127.0.0.1:50062"]
ENTRYPOINT ["curvd"]
