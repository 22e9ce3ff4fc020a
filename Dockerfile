# A machine that can build and test hexcast: Debian 12 with Rust and Node, and what scripts/machine.mjs lists.
#
#     docker build -t hexcast . && docker run --rm hexcast

FROM node:22-bookworm-slim AS node
FROM rust:1-bookworm
COPY --from=node /usr/local/bin/node /usr/local/bin/
COPY --from=node /usr/local/lib/node_modules /usr/local/lib/node_modules
RUN ln -s ../lib/node_modules/npm/bin/npm-cli.js /usr/local/bin/npm && ln -s ../lib/node_modules/npm/bin/npx-cli.js /usr/local/bin/npx
RUN rustup component add clippy rustfmt && rustup target add wasm32-unknown-unknown
WORKDIR /hexcast
COPY . .
RUN npm run setup
CMD ["npm", "test"]
