#!/usr/bin/env bash
# The whole way on a built-in sequence: generates an arm, extracts features, trains on every other
# shape, measures the rest, exports the components and mixes the strongest ones. Everything goes to
# demo/, which may be removed.
set -euo pipefail
cd "$(dirname "$0")/.."

bin=build/release/bin
summary=()

stage() {  # stage NAME COMMAND...
    local name=$1 begin=$SECONDS
    shift
    printf '\n== %s: %s\n' "$name" "$*"
    "$@"
    summary+=("$(printf '%-10s %3d:%02d' "$name" $(((SECONDS - begin) / 60)) $(((SECONDS - begin) % 60)))")
}

stage install scripts/setup.sh
stage build scripts/build.sh release acapfeat mscomp

mkdir -p demo
rm -rf demo/arm demo/arm.safetensors demo/config.yaml demo/arm.run demo/components demo/measures \
    demo/synthesis.png
stage generate "$bin/acapfeat" generate arm -o demo/arm
stage extract "$bin/acapfeat" extract demo/arm -o demo/arm.safetensors
"$bin/mscomp" init >demo/config.yaml
stage train "$bin/mscomp" train demo/config.yaml -o demo/arm.run \
    --set data.features=arm.safetensors --set 'data.split={train: every, step: 2}'
stage evaluate "$bin/mscomp" evaluate demo/arm.run -o demo/measures
stage export "$bin/mscomp" export-components demo/arm.run -o demo/components
stage synthesize "$bin/mscomp" synthesize demo/arm.run --sheet demo/synthesis.png --strongest 3 \
    --weights 0.3,0.7,1.1

printf '\nminutes:seconds of each stage\n'
printf '  %s\n' "${summary[@]}"
cat <<END

Done. Look at
  demo/components/overview.png      all components, each beside the one it refines, blue where it moves
  demo/components/*.ply             each one as a coloured mesh
  demo/synthesis.png                the three strongest, a third of the way, most of it and beyond
  demo/measures/errors.png          the worst of the shapes that were not trained on
  demo/components/components.json   what each one is: level, parent, centre, strength, support
  demo/arm/truth.json               what the arm was really made of
END
