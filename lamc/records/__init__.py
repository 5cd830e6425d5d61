"""The records that pass between stages: designs, mechanisms, scenes, inputs. They check themselves."""
