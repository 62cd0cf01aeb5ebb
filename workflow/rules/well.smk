"""The folder of one stage of one well as a target, such as results/main/fits/W1.

Nothing is run here: the stage's job of the batch that holds the well has filled the folder.
"""


rule well:
    input:
        manifest_of_well(),
    output:
        directory("<results>/{stage}/{well}"),
