"""Reads the conda recipe as rattler-build does, without building it."""

import pathlib
import sys

import rattler_build

recipe = rattler_build.Stage0Recipe.from_yaml(pathlib.Path(sys.argv[1]).read_text())
variants = rattler_build.VariantConfig({"python": ["3.12.*"], "c_compiler": ["gcc"], "rust_compiler": ["rust"], "c_stdlib": ["sysroot"]})
for rendered in recipe.render(variants):
    built = rendered.recipe
    print(f"recipe: {built.package.name} {built.package.version}, run: {[str(r) for r in built.requirements.run]}")
